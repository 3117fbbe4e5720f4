//! The responses of a map that get a surface and pictures of their own, and their short names.

use crate::frf::{ComplianceMap, Quantity};

/// One entry of the map's matrix.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Response {
    /// Index of the output.
    pub output: usize,
    /// Index of the input.
    pub input: usize,
    /// Name in files and pictures: `xx` for the output `tool.x` and the input `tool.x`.
    pub label: String,
}

/// The direct responses of a map: every output that is an input too, in the order of the outputs.
///
/// The label is made of the last parts of the names (`tool.x` and `tool.x`: `xx`); where two
/// responses would share it, of the whole names with `_` for what a file name should not hold.
pub fn direct_responses(map: &ComplianceMap) -> Vec<Response> {
    direct_responses_of(&map.outputs, &map.inputs)
}

/// As [`direct_responses`], from the names of the outputs and inputs.
pub fn direct_responses_of(outputs: &[String], inputs: &[String]) -> Vec<Response> {
    let mut found = Vec::new();
    for (output, name) in outputs.iter().enumerate() {
        if let Some(input) = inputs.iter().position(|i| i == name) {
            found.push(Response { output, input, label: short(name).repeat(2) });
        }
    }
    let labels: Vec<_> = found.iter().map(|r| r.label.clone()).collect();
    for response in &mut found {
        if labels.iter().filter(|l| **l == response.label).count() > 1 {
            let whole = safe(&outputs[response.output]);
            response.label = format!("{whole}_{whole}");
        }
    }
    found
}

/// The unit of the map's values.
pub const fn unit(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Receptance => "m/N",
        Quantity::Mobility => "m/(s N)",
        Quantity::Accelerance => "m/(s^2 N)",
    }
}

/// Index of an entry in [`ComplianceMap::values`].
pub(crate) fn index(map: &ComplianceMap, position: usize, frequency: usize, r: &Response) -> usize {
    let (n_out, n_in) = (map.outputs.len(), map.inputs.len());
    ((position * map.frequencies.len() + frequency) * n_out + r.output) * n_in + r.input
}

fn short(name: &str) -> String {
    safe(name.rsplit(['.', ' ', ':', '/']).next().unwrap_or(name))
}

/// A name as part of a file's name: letters, digits and hyphens stay, the rest becomes `_`.
pub fn safe(name: &str) -> String {
    name.chars().map(|c| if c.is_alphanumeric() || c == '-' { c } else { '_' }).collect()
}
