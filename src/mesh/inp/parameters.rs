//! Parameters of keywords: which are read, which change nothing, and what is refused.

use super::lines::{Keyword, Lines, canonical};
use crate::mesh::MeshError;

/// A parameter and the values with which it changes nothing; none: it changes nothing whatever its value.
pub type Neutral = (&'static str, &'static [&'static str]);

/// Refuses parameters that would change the result: all but those that are `read` by the caller, and those
/// of `neutral` with a value that changes nothing. Dependencies on no field change nothing anywhere.
///
/// # Errors
/// [`MeshError::Parameter`] with the value seen.
pub fn check_parameters(
    keyword: &Keyword<'_>,
    name: &'static str,
    read: &[&str],
    neutral: &[Neutral],
    allowed: &'static str,
    lines: &Lines<'_>,
) -> Result<(), MeshError> {
    const EVERYWHERE: Neutral = ("DEPENDENCIES", &["0"]);
    for (parameter, _) in keyword.parameters.iter().filter(|(p, _)| !read.contains(&p.as_str())) {
        let value = keyword.get(parameter).unwrap_or_default();
        let known = neutral.iter().chain([&EVERYWHERE]).find(|(other, _)| other == parameter);
        let seen = match known {
            None => format!("the parameter {parameter} is not supported"),
            Some((_, values)) if values.is_empty() || values.contains(&canonical(value).as_str()) => continue,
            Some(_) if value.is_empty() => format!("the parameter {parameter} is not supported"),
            Some(_) => format!("{parameter}={value} is not supported"),
        };
        let spot = lines.spot(keyword.line);
        return Err(MeshError::Parameter {
            spot,
            keyword: name,
            seen,
            allowed,
            advice: "remove it if it does not matter",
        });
    }
    Ok(())
}
