//! The name that was probably meant.

/// The candidate closest to `name`, if one is close enough to be a likely misspelling of it.
///
/// Closeness is the Damerau-Levenshtein distance, case ignored; a third of the longer name's letters
/// (two at least) may differ. A candidate that begins with `name`, or that `name` begins with, is close
/// too.
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let wanted = name.to_lowercase();
    candidates
        .into_iter()
        .filter_map(|candidate| {
            let other = candidate.to_lowercase();
            let distance = strsim::damerau_levenshtein(&wanted, &other);
            let longer = wanted.chars().count().max(other.chars().count());
            let shares_start = wanted.chars().count().min(other.chars().count()) >= 3
                && (other.starts_with(&wanted) || wanted.starts_with(&other));
            (distance < longer && distance <= (longer / 3).max(2) || shares_start).then_some((distance, candidate))
        })
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, candidate)| candidate)
}

#[cfg(test)]
mod tests {
    use super::nearest;

    #[test]
    fn a_misspelling_finds_the_name_and_a_stranger_finds_none() {
        let names = ["stiffness", "damping", "between"];
        assert_eq!(nearest("stifness", names), Some("stiffness"));
        assert_eq!(nearest("DAMPNIG", names), Some("damping"));
        assert_eq!(nearest("damp", names), Some("damping"));
        assert_eq!(nearest("colour", names), None);
    }
}
