//! Keyframes: where a camera is at a time, in the words of people. In: numbers, or an object of JSON. Out: checked keyframes.

use super::PathError;
use crate::draw::view_line::Stand;
use serde::{Deserialize, Serialize};

/// Where a camera is at a time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Written", into = "Written")]
pub struct Keyframe {
    /// Seconds since the start of the path, 0 to 1e6.
    pub time_s: f64,
    /// Degrees north, -90 to 90.
    pub latitude: f64,
    /// Degrees east, -360 to 360. At a pole it says which way north is.
    pub longitude: f64,
    /// How far above that.
    pub stand: Stand,
    /// Degrees clockwise from north, -360 to 360.
    pub heading: f64,
    /// Degrees above the horizontal, -90 to 90.
    pub pitch: f64,
    /// Vertical field of view in degrees, 7 to 140.
    pub fov: f64,
}

/// A keyframe as JSON has it: with one of two keys for how far it is above its site.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    time_s: f64,
    latitude: f64,
    longitude: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    altitude_m: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    height_m: Option<f64>,
    heading: f64,
    pitch: f64,
    fov: f64,
}

impl TryFrom<Written> for Keyframe {
    type Error = &'static str;

    fn try_from(written: Written) -> Result<Keyframe, Self::Error> {
        let Written { time_s, latitude, longitude, altitude_m, height_m, heading, pitch, fov } = written;
        let stand = match (altitude_m, height_m) {
            (Some(metres), None) => Stand::Altitude(metres),
            (None, Some(metres)) => Stand::Height(metres),
            (None, None) => {
                return Err("missing field `altitude_m` (metres above ground or sea) or `height_m` (above the datum)")
            }
            (Some(_), Some(_)) => return Err("found both `altitude_m` and `height_m`, expected one of them"),
        };
        Ok(Keyframe { time_s, latitude, longitude, stand, heading, pitch, fov })
    }
}

impl From<Keyframe> for Written {
    fn from(keyframe: Keyframe) -> Written {
        let Keyframe { time_s, latitude, longitude, stand, heading, pitch, fov } = keyframe;
        let (altitude_m, height_m) = match stand {
            Stand::Altitude(metres) => (Some(metres), None),
            Stand::Height(metres) => (None, Some(metres)),
        };
        Written { time_s, latitude, longitude, altitude_m, height_m, heading, pitch, fov }
    }
}

/// Legal values: name, how to get it, least, most, in words.
type Rule = (&'static str, fn(&Keyframe) -> f64, f64, f64, &'static str);

const RULES: [Rule; 6] = [
    ("time_s", |k| k.time_s, 0.0, 1e6, "0 to 1e6 seconds"),
    ("latitude", |k| k.latitude, -90.0, 90.0, "-90 to 90 degrees"),
    ("longitude", |k| k.longitude, -360.0, 360.0, "-360 to 360 degrees"),
    ("heading", |k| k.heading, -360.0, 360.0, "-360 to 360 degrees"),
    ("pitch", |k| k.pitch, -90.0, 90.0, "-90 to 90 degrees"),
    ("fov", |k| k.fov, 7.0, 140.0, "7 to 140 degrees"),
];

/// The quantity that says how far a keyframe is above its site: name, value, range, in words.
fn stand(keyframe: &Keyframe) -> (&'static str, f64, std::ops::RangeInclusive<f64>, &'static str) {
    match keyframe.stand {
        Stand::Altitude(metres) => ("altitude_m", metres, 0.5..=1e9, "0.5 to 1e9 metres"),
        Stand::Height(metres) => ("height_m", metres, -1e8..=1e9, "-1e8 to 1e9 metres"),
    }
}

/// Refuses keyframes that make no path.
pub(super) fn check(keyframes: &[Keyframe]) -> Result<(), PathError> {
    if keyframes.len() < 2 {
        return Err(PathError::TooFew { found: keyframes.len() });
    }
    for (number, keyframe) in keyframes.iter().enumerate() {
        for (what, value, least, most, expected) in RULES {
            let found = value(keyframe);
            if !(least..=most).contains(&found) {
                return Err(PathError::Value { number, what, found, expected });
            }
        }
        let (what, found, range, expected) = stand(keyframe);
        if !range.contains(&found) {
            return Err(PathError::Value { number, what, found, expected });
        }
        let (first, ..) = stand(&keyframes[0]);
        if what != first {
            return Err(PathError::Mixed { number, found: what, expected: first });
        }
        if number > 0 && keyframe.time_s <= keyframes[number - 1].time_s {
            return Err(PathError::Order { number, time_s: keyframe.time_s });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const LINE: &str = r#"{"time_s":1.0,"latitude":2.0,"longitude":3.0,"altitude_m":4.0,"heading":5.0,"pitch":6.0,"fov":50.0}"#;

    fn read(text: &str) -> Result<Keyframe, String> {
        serde_json::from_str(text).map_err(|error| error.to_string())
    }

    #[test]
    fn a_keyframe_stands_above_the_ground_or_above_the_datum() {
        assert_eq!(read(LINE).unwrap().stand, Stand::Altitude(4.0));
        assert_eq!(read(&LINE.replace("altitude_m", "height_m")).unwrap().stand, Stand::Height(4.0));
        let neither = read(&LINE.replace(r#""altitude_m":4.0,"#, "")).unwrap_err();
        assert!(neither.contains("missing field `altitude_m`"), "{neither}");
        let both = read(&LINE.replace(r#""heading""#, r#""height_m":1.0,"heading""#)).unwrap_err();
        assert!(both.contains("found both"), "{both}");
        assert!(read(&LINE.replace("fov", "zoom")).unwrap_err().contains("unknown field `zoom`"));
    }

    proptest! {
        #[test]
        fn keyframes_come_back_from_json_to_the_bit(
            numbers in [0.0..1e6f64, -90.0..90.0f64, -360.0..360.0f64, 0.5..1e9f64, -360.0..360.0f64, -90.0..90.0f64, 7.0..140.0f64],
            level in any::<bool>(),
        ) {
            let [time_s, latitude, longitude, metres, heading, pitch, fov] = numbers;
            let stand = if level { Stand::Height(-metres) } else { Stand::Altitude(metres) };
            let keyframe = Keyframe { time_s, latitude, longitude, stand, heading, pitch, fov };
            prop_assert_eq!(read(&serde_json::to_string(&keyframe).unwrap()).unwrap(), keyframe);
        }
    }
}
