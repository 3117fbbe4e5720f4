//! Forces as they are written on the command line: `KIND,key=value,..`.

use super::cutter::{CutterPort, directions};
use super::{Milling, Pulse, PulseShape, ResponseError, Shape};

/// The values of `KIND,key=value,..`, which are taken out one by one.
struct Words<'a> {
    what: &'a str,
    values: Vec<(&'a str, &'a str)>,
    asked: Vec<&'static str>,
}

/// Which numbers a value may be.
#[derive(Clone, Copy)]
enum Bound {
    Any,
    NotNegative,
    Positive,
}

impl<'a> Words<'a> {
    fn new(what: &'a str, words: &'a str) -> Result<Self, ResponseError> {
        let mut values: Vec<(&str, &str)> = Vec::new();
        for word in words.split(',').filter(|w| !w.trim().is_empty()) {
            let Some((key, value)) = word.split_once('=') else {
                return Err(ResponseError::not_allowed(what, format!("{word:?}"), "key=value, separated by commas"));
            };
            let key = key.trim();
            if values.iter().any(|(k, _)| *k == key) {
                return Err(ResponseError::not_allowed(what, format!("{key} twice"), "each key once"));
            }
            values.push((key, value.trim()));
        }
        Ok(Self { what, values, asked: Vec::new() })
    }

    fn text(&mut self, key: &'static str) -> Option<&'a str> {
        self.asked.push(key);
        self.values.iter().position(|(k, _)| *k == key).map(|at| self.values.remove(at).1)
    }

    fn number(&mut self, key: &'static str, default: Option<f64>, bound: Bound) -> Result<f64, ResponseError> {
        let Some(text) = self.text(key) else {
            return default.ok_or_else(|| {
                ResponseError::not_allowed(self.what, format!("no {key}"), format!("{key}=NUMBER, which must be there"))
            });
        };
        let (holds, allowed): (fn(f64) -> bool, _) = match bound {
            Bound::Any => (|_| true, "a finite number"),
            Bound::NotNegative => (|v| v >= 0.0, "zero or a positive number"),
            Bound::Positive => (|v| v > 0.0, "a positive number"),
        };
        match text.parse::<f64>() {
            Ok(value) if value.is_finite() && holds(value) => Ok(value),
            _ => Err(ResponseError::not_allowed(format!("{}: {key}", self.what), text, allowed)),
        }
    }

    fn whole(&mut self, key: &'static str, least: u64) -> Result<u64, ResponseError> {
        match self.text(key) {
            Some(text) => whole(self.what, key, text, least),
            None => Err(ResponseError::not_allowed(
                self.what,
                format!("no {key}"),
                format!("{key}=NUMBER, which must be there"),
            )),
        }
    }

    fn finish(self) -> Result<(), ResponseError> {
        match self.values.first() {
            None => Ok(()),
            Some((key, _)) => Err(ResponseError::not_allowed(
                self.what,
                format!("the key {key:?}"),
                if self.asked.is_empty() { "no keys".to_owned() } else { self.asked.join(", ") },
            )),
        }
    }
}

fn whole(what: &str, key: &str, text: &str, least: u64) -> Result<u64, ResponseError> {
    text.parse::<u64>().ok().filter(|n| *n >= least).ok_or_else(|| {
        ResponseError::not_allowed(format!("{what}: {key}"), text, format!("a whole number of at least {least}"))
    })
}

/// A force as text, such as `sine,amplitude=10,frequency=200`; N, s, Hz and degrees.
///
/// | kind | keys with what they are if left out |
/// |---|---|
/// | `impulse` | `amplitude=1`, `length=0.001`, `shape=half-sine` (`rectangle`, `triangle`), `start=0` |
/// | `step` | `amplitude=1`, `start=0` |
/// | `sine` | `amplitude=1`, `frequency`, `phase=0` |
/// | `chirp` | `amplitude=1`, `from`, `to` |
/// | `random` | `rms=1`, `seed` (without it each input has its own) |
///
/// # Errors
/// [`ResponseError::NotAllowed`] with key, value and what is allowed.
pub fn parse_force(text: &str) -> Result<Shape, ResponseError> {
    let (kind, words) = text.split_once(',').unwrap_or((text, ""));
    let what = format!("the force {kind:?}");
    let mut words = Words::new(&what, words)?;
    let shape = match kind.trim() {
        "impulse" => Shape::Impulse(Pulse {
            amplitude: words.number("amplitude", Some(1.0), Bound::Any)?,
            length: words.number("length", Some(1e-3), Bound::Positive)?,
            shape: match words.text("shape") {
                None | Some("half-sine") => PulseShape::HalfSine,
                Some("rectangle") => PulseShape::Rectangle,
                Some("triangle") => PulseShape::Triangle,
                Some(other) => {
                    let allowed = "half-sine, rectangle, triangle";
                    return Err(ResponseError::not_allowed(format!("{what}: shape"), other, allowed));
                }
            },
            start: words.number("start", Some(0.0), Bound::NotNegative)?,
        }),
        "step" => Shape::Step {
            amplitude: words.number("amplitude", Some(1.0), Bound::Any)?,
            start: words.number("start", Some(0.0), Bound::NotNegative)?,
        },
        "sine" => Shape::Sine {
            amplitude: words.number("amplitude", Some(1.0), Bound::Any)?,
            frequency: words.number("frequency", None, Bound::Positive)?,
            phase: words.number("phase", Some(0.0), Bound::Any)?,
        },
        "chirp" => Shape::Chirp {
            amplitude: words.number("amplitude", Some(1.0), Bound::Any)?,
            from: words.number("from", None, Bound::NotNegative)?,
            to: words.number("to", None, Bound::NotNegative)?,
        },
        "random" => Shape::Random {
            rms: words.number("rms", Some(1.0), Bound::NotNegative)?,
            seed: words.text("seed").map(|text| whole(&what, "seed", text, 0)).transpose()?,
        },
        other => {
            let allowed = "impulse, step, sine, chirp, random (and --milling, --force-file)";
            return Err(ResponseError::not_allowed("the kind of a force", format!("{other:?}"), allowed));
        }
    };
    words.finish()?;
    Ok(shape)
}

/// A milling cut as text: `teeth=4,speed=3000,feed=0.1,depth=2,kt=2000,kr=0.3`.
///
/// `speed` in 1/min, `feed` in mm a tooth, `depth` in mm, `kt` in N/mm^2, `entry=0` and `exit=180` in degrees. `along`
/// and `across` are the inputs of the feed and the normal direction, `-x` for the opposite of x; what is left out is
/// taken across the spindle of `port`, or of the only port on a part that bearings alone hold.
///
/// # Errors
/// [`ResponseError::NotAllowed`] with key, value and what is allowed.
pub fn parse_milling(text: &str, ports: &[CutterPort]) -> Result<Milling, ResponseError> {
    let what = "--milling";
    let mut words = Words::new(what, text)?;
    let teeth = words.whole("teeth", 1)? as usize;
    let speed = words.number("speed", None, Bound::Positive)? / 60.0;
    let feed = 1e-3 * words.number("feed", None, Bound::NotNegative)?;
    let depth = 1e-3 * words.number("depth", None, Bound::NotNegative)?;
    let kt = 1e6 * words.number("kt", None, Bound::NotNegative)?;
    let kr = words.number("kr", None, Bound::NotNegative)?;
    let entry = words.number("entry", Some(0.0), Bound::NotNegative)?.to_radians();
    let exit = words.number("exit", Some(180.0), Bound::NotNegative)?.to_radians();
    let (port, along, across) = (words.text("port"), words.text("along"), words.text("across"));
    words.finish()?;
    if teeth > 1000 {
        return Err(ResponseError::not_allowed("--milling: teeth", teeth, "1 to 1000"));
    }
    if !(entry < exit && exit <= std::f64::consts::PI * (1.0 + 1e-12)) {
        let seen = format!("{} to {} degrees", entry.to_degrees(), exit.to_degrees());
        return Err(ResponseError::not_allowed(
            "--milling: entry and exit",
            seen,
            "0 <= entry < exit <= 180: beyond 180 degrees the chip thickness, feed times sin(angle), is negative",
        ));
    }
    let [(feed_input, of_feed), (normal_input, of_normal)] = directions(ports, port, along, across)?;
    let signs = [of_feed, of_normal];
    Ok(Milling { teeth, speed, feed, depth, kt, kr, entry, exit, feed_input, normal_input, signs })
}
