//! A view as one line of text, `terrane:1/planet=Terra/at=-38.95,34.34/altitude=1000/…`: all that decides a picture. In: text, or what a
//! picture was drawn with. Out: the other. Its grammar is in docs/views.md; numbers come back to the bit.

mod grammar;

use super::layout::{Mode, Tone};
use super::view::TOLERANCE_RANGE;
use grammar::{escape, Parts};
use jiff::Timestamp;
use std::fmt::{self, Display, Formatter};
use std::str::FromStr;
use thiserror::Error;

/// What every view begins with, before its version.
pub const SCHEME: &str = "terrane:";

/// Version of the grammar. It grows when a key that an older reader knows changes its meaning, or a default does.
pub const VERSION: u32 = 1;

/// Where the camera stands over its site.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stand {
    /// Metres above the ground or the sea, 0.5 to 1e9.
    Altitude(f64),
    /// Metres above the datum, -1e8 to 1e9.
    Height(f64),
}

/// Where the sun stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Daylight {
    /// Degrees clockwise from north and above the horizon, as seen from the site below the camera.
    Over([f64; 2]),
    /// Whole seconds since 1970, as [`crate::globe::sun::direction`] takes them.
    Date(i64),
}

/// How bright a picture is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exposure {
    /// By the picture's luminance too.
    Auto,
    /// A factor from 1e-6 to 1e6 on what the light below the camera asks for.
    Fixed(f32),
}

/// A view. What is `None` or false is as commands have it where nothing is said.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewLine {
    /// Name of the planet.
    pub planet: Option<String>,
    /// Checksum of the planet's recipe and grid, [`crate::store::PlanetHeader::checksum`].
    pub recipe: Option<u32>,
    /// Latitude (-90 to 90) and longitude (-360 to 360) in degrees.
    pub at: [f64; 2],
    /// How far above that.
    pub stand: Stand,
    /// Degrees clockwise from north, and degrees above the horizontal (-90 to 90).
    pub look: Option<[f64; 2]>,
    /// Vertical field of view in degrees, 7 to 140.
    pub fov: Option<f64>,
    /// Width and height in pixels, 16 to 16384.
    pub size: Option<[u32; 2]>,
    /// Tolerance in pixels, within [`TOLERANCE_RANGE`].
    pub error: Option<f64>,
    /// The sun.
    pub daylight: Option<Daylight>,
    /// The brightness.
    pub exposure: Option<Exposure>,
    /// What is drawn.
    pub mode: Option<Mode>,
    /// The tone curve.
    pub tone: Option<Tone>,
    /// Seconds that waves have run, 0 to 1e9.
    pub time: Option<f64>,
    /// Metres between samples to which patches are built, 0.01 to 1e9.
    pub spacing: Option<f64>,
    /// Samples a pixel in each direction of a still, 1 to 4.
    pub ssaa: Option<u32>,
    /// Samples a pixel of the ground's edges: 1, 2, 4 or 8.
    pub msaa: Option<u32>,
    /// Bits a channel, 8 or 16.
    pub depth: Option<u32>,
    /// Without clouds.
    pub clear_sky: bool,
    /// Without the sea.
    pub no_sea: bool,
    /// Without air.
    pub no_air: bool,
    /// Without shadows of the relief.
    pub no_shadows: bool,
    /// With alpha in place of space.
    pub transparent_sky: bool,
    /// Vertices jump when they wake.
    pub no_geomorphs: bool,
    /// Errors count as they are seen.
    pub orientation: bool,
    /// Only patches of the planet file.
    pub stored_only: bool,
}

/// Why text is no view.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ViewLineError {
    /// Something else.
    #[error("'{found}' is no view: expected {SCHEME}{VERSION}/…, such as {SCHEME}{VERSION}/planet=Terra/at=-38.95,34.34/altitude=1000")]
    Foreign {
        /// Its beginning.
        found: String,
    },
    /// Another version.
    #[error("a view of version '{found}', expected {VERSION}; a newer terrane wrote it, or it was cut short")]
    Version {
        /// The version.
        found: String,
    },
    /// A part that cannot be.
    #[error("view, character {at}, '{part}': found {found}, expected {expected}")]
    Part {
        /// Where the part begins, in characters from 1.
        at: usize,
        /// The part.
        part: String,
        /// What is wrong.
        found: String,
        /// What it can be.
        expected: String,
    },
    /// A part that must be there.
    #[error("view: found no {missing}, expected {expected}")]
    Missing {
        /// Its key.
        missing: &'static str,
        /// What it can be.
        expected: &'static str,
    },
}

impl ViewLine {
    /// The time by which the sun stands, in seconds since 1970, if it stands by one.
    pub fn date(&self) -> Option<i64> {
        match self.daylight {
            Some(Daylight::Date(second)) => Some(second),
            _ => None,
        }
    }

    /// The view from a site, everything else as usual.
    pub fn from_site(at: [f64; 2], stand: Stand) -> ViewLine {
        ViewLine {
            planet: None,
            recipe: None,
            at,
            stand,
            look: None,
            fov: None,
            size: None,
            error: None,
            daylight: None,
            exposure: None,
            mode: None,
            tone: None,
            time: None,
            spacing: None,
            ssaa: None,
            msaa: None,
            depth: None,
            clear_sky: false,
            no_sea: false,
            no_air: false,
            no_shadows: false,
            transparent_sky: false,
            no_geomorphs: false,
            orientation: false,
            stored_only: false,
        }
    }
}

impl FromStr for ViewLine {
    type Err = ViewLineError;

    fn from_str(text: &str) -> Result<ViewLine, ViewLineError> {
        let mut parts = Parts::of(text)?;
        let at = parts.take("at", "latitude and longitude in degrees, -90 to 90 and -360 to 360", |text| {
            let [latitude, longitude] = grammar::numbers(text)?;
            ((-90.0..=90.0).contains(&latitude) && (-360.0..=360.0).contains(&longitude)).then_some([latitude, longitude])
        })?;
        let altitude = parts.number("altitude", 0.5..=1e9, "0.5 to 1e9 metres above ground or sea, and no height")?;
        let height = parts.number("height", -1e8..=1e9, "-1e8 to 1e9 metres above the datum, and no altitude")?;
        let sun = parts.take("sun", "degrees clockwise from north and above the horizon, and no date", grammar::numbers)?;
        let date = parts.take("date", "a time such as 2026-06-21T12:00:00Z, and no sun", |text| {
            text.parse::<Timestamp>().ok().map(|time| time.as_second())
        })?;
        let (least, most) = TOLERANCE_RANGE;
        let missing = |missing, expected| ViewLineError::Missing { missing, expected };
        let line = ViewLine {
            planet: parts.take(
                "planet",
                "a planet's name, other characters than letters, digits, - _ . as %XX",
                grammar::unescape,
            )?,
            recipe: parts
                .take("recipe", "8 hexadecimal digits", |text| u32::from_str_radix(text, 16).ok().filter(|_| text.len() == 8))?,
            at: at.ok_or(missing("at", "at=LATITUDE,LONGITUDE"))?,
            stand: match (altitude, height) {
                (Some(altitude), None) => Stand::Altitude(altitude),
                (None, Some(height)) => Stand::Height(height),
                (None, None) => {
                    return Err(missing("altitude", "altitude=METRES above ground or sea, or height=METRES above the datum"))
                }
                (Some(_), Some(_)) => return Err(parts.both("altitude", "height")),
            },
            look: parts.take("look", "degrees clockwise from north, and degrees above the horizontal, -90 to 90", |text| {
                grammar::numbers(text).filter(|[_, pitch]| (-90.0..=90.0).contains(pitch))
            })?,
            fov: parts.number("fov", 7.0..=140.0, "7 to 140 degrees")?,
            size: parts.take("size", "pixels such as 1280x720, sides from 16 to 16384", |text| {
                let (width, height) = text.split_once('x')?;
                let size = [width.parse().ok()?, height.parse().ok()?];
                size.iter().all(|side| (16..=16_384).contains(side)).then_some(size)
            })?,
            error: parts.number("error", least..=most, "0.05 to 64 pixels")?,
            daylight: match (sun, date) {
                (Some(_), Some(_)) => return Err(parts.both("sun", "date")),
                (sun, date) => sun.map(Daylight::Over).or(date.map(Daylight::Date)),
            },
            exposure: parts.take("exposure", "auto, or a factor from 1e-6 to 1e6", |text| match text {
                "auto" => Some(Exposure::Auto),
                _ => text.parse().ok().filter(|factor| (1e-6..=1e6).contains(factor)).map(Exposure::Fixed),
            })?,
            mode: parts.take("mode", "shaded, wire, levels, normals, albedo, depth, wake or error", |text| {
                Mode::ALL.iter().copied().find(|mode| mode.name() == text)
            })?,
            tone: parts.take("tone", "neutral or agx", |text| Tone::ALL.into_iter().find(|tone| tone.name() == text))?,
            time: parts.number("time", 0.0..=1e9, "0 to 1e9 seconds")?,
            spacing: parts.number("spacing", 0.01..=1e9, "0.01 to 1e9 metres")?,
            ssaa: parts.one_of("ssaa", &[1, 2, 3, 4], "1 to 4")?,
            msaa: parts.one_of("msaa", &[1, 2, 4, 8], "1, 2, 4 or 8")?,
            depth: parts.one_of("depth", &[8, 16], "8 or 16")?,
            clear_sky: parts.flag("clear-sky")?,
            no_sea: parts.flag("no-sea")?,
            no_air: parts.flag("no-air")?,
            no_shadows: parts.flag("no-shadows")?,
            transparent_sky: parts.flag("transparent-sky")?,
            no_geomorphs: parts.flag("no-geomorphs")?,
            orientation: parts.flag("orientation")?,
            stored_only: parts.flag("stored-only")?,
        };
        parts.finish()?;
        Ok(line)
    }
}

impl Display for ViewLine {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let pair = |[a, b]: [f64; 2]| format!("{a},{b}");
        let number = |number: f64| number.to_string();
        let count = |count: u32| count.to_string();
        let (altitude, height) = match self.stand {
            Stand::Altitude(metres) => (Some(metres), None),
            Stand::Height(metres) => (None, Some(metres)),
        };
        let (sun, date) = match self.daylight {
            Some(Daylight::Over(sun)) => (Some(sun), None),
            Some(Daylight::Date(second)) => (None, Timestamp::from_second(second).ok()),
            None => (None, None),
        };
        let exposure = self.exposure.map(|exposure| match exposure {
            Exposure::Auto => "auto".to_owned(),
            Exposure::Fixed(factor) => factor.to_string(),
        });
        let values = [
            ("planet", self.planet.as_deref().map(escape)),
            ("recipe", self.recipe.map(|checksum| format!("{checksum:08x}"))),
            ("at", Some(pair(self.at))),
            ("altitude", altitude.map(number)),
            ("height", height.map(number)),
            ("look", self.look.map(pair)),
            ("fov", self.fov.map(number)),
            ("size", self.size.map(|[width, height]| format!("{width}x{height}"))),
            ("sun", sun.map(pair)),
            ("date", date.map(|date| date.to_string())),
            ("error", self.error.map(number)),
            ("exposure", exposure),
            ("mode", self.mode.map(|mode| mode.name().to_owned())),
            ("tone", self.tone.map(|tone| tone.name().to_owned())),
            ("time", self.time.map(number)),
            ("spacing", self.spacing.map(number)),
            ("ssaa", self.ssaa.map(count)),
            ("msaa", self.msaa.map(count)),
            ("depth", self.depth.map(count)),
        ];
        let flags = [
            ("clear-sky", self.clear_sky),
            ("no-sea", self.no_sea),
            ("no-air", self.no_air),
            ("no-shadows", self.no_shadows),
            ("transparent-sky", self.transparent_sky),
            ("no-geomorphs", self.no_geomorphs),
            ("orientation", self.orientation),
            ("stored-only", self.stored_only),
        ];
        write!(f, "{SCHEME}{VERSION}")?;
        values.iter().try_for_each(|(key, value)| value.iter().try_for_each(|value| write!(f, "/{key}={value}")))?;
        flags.iter().filter(|(_, on)| *on).try_for_each(|(key, _)| write!(f, "/{key}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const FULL: &str = "terrane:1/planet=Terra/recipe=00c0ffee/at=-38.95,34.34/altitude=1000/look=310,-11/fov=50/size=1280x720/\
                        date=2026-06-21T12:00:00Z/error=0.5/exposure=auto/mode=wire/tone=agx/time=1.5/spacing=2/ssaa=2/msaa=4/depth=16/\
                        clear-sky/no-sea/no-air/no-shadows/transparent-sky/no-geomorphs/orientation/stored-only";

    fn message(text: &str) -> String {
        text.parse::<ViewLine>().unwrap_err().to_string()
    }

    #[test]
    fn every_key_comes_back_in_any_order() {
        let line: ViewLine = FULL.parse().unwrap();
        assert_eq!(line.to_string(), FULL);
        let mut parts: Vec<&str> = FULL.split('/').skip(1).collect();
        parts.reverse();
        assert_eq!(format!(" terrane:1/{}\n", parts.join("/")).parse(), Ok(line));
    }

    #[test]
    fn a_site_is_enough() {
        let line: ViewLine = "terrane:1/at=46,8/height=-20.5".parse().unwrap();
        assert_eq!(line, ViewLine::from_site([46.0, 8.0], Stand::Height(-20.5)));
    }

    #[test]
    fn text_that_is_no_view_is_refused_with_place_found_and_expected() {
        let full = |from: &str, to: &str| message(&FULL.replace(from, to));
        assert!(message("46,8").contains("'46,8' is no view"));
        assert!(message("terrane:2/at=1,2/altitude=3").contains("version '2', expected 1"));
        assert!(message("terrane:1/altitude=3").contains("no at, expected at="));
        assert!(message("terrane:1/at=1,2").contains("no altitude"));
        assert!(message("terrane:1/at=1,2/altitude=3/height=4").contains("character 29, 'height=4': found both"));
        assert_eq!(full("fov=50", "fov=500"), "view, character 83, 'fov=500': found '500', expected 7 to 140 degrees");
        for (from, to, part) in [
            ("at=-38.95,34.34", "at=-98,3", "latitude and longitude"),
            ("altitude=1000", "altitude=NaN", "0.5 to 1e9 metres"),
            ("look=310,-11", "look=310", "degrees clockwise"),
            ("size=1280x720", "size=1280", "such as 1280x720"),
            ("date=2026-06-21T12:00:00Z", "date=yesterday", "2026-06-21T12:00:00Z"),
            ("exposure=auto", "exposure=0", "1e-6"),
            ("mode=wire", "mode=sepia", "wake or error"),
            ("recipe=00c0ffee", "recipe=coffee", "8 hexadecimal digits"),
            ("planet=Terra", "planet=T%4", "%XX"),
            ("clear-sky", "clear-sky=yes", "no value"),
            ("ssaa=2", "ssaa=2/ssaa=2", "found it twice"),
            ("ssaa=2", "colour=2", "one of at, altitude, height"),
            ("ssaa=2", "", "one of at, altitude, height"),
            ("fov=50", "fov", "=VALUE"),
        ] {
            assert!(full(from, to).contains(part), "{to}: {}", full(from, to));
        }
    }

    proptest! {
        #[test]
        fn numbers_and_names_come_back_to_the_bit(
            at in [-90.0..=90.0, -360.0..=360.0], metres in -1e8..=1e9, look in [-1e3..=1e3, -90.0..=90.0], fov in 7.0..=140.0,
            factor in 1e-6f32..=1e6, second in -60_000_000_000i64..=200_000_000_000, planet in ".*", recipe: u32,
        ) {
            let mut line = ViewLine::from_site(at, Stand::Height(metres));
            line.look = Some(look);
            line.fov = Some(fov);
            line.exposure = Some(Exposure::Fixed(factor));
            line.daylight = Some(Daylight::Date(second));
            line.planet = Some(planet);
            line.recipe = Some(recipe);
            let text = line.to_string();
            prop_assert!(text.bytes().all(|byte| byte.is_ascii_graphic()), "{}", text);
            prop_assert_eq!(text.parse(), Ok(line));
        }

        #[test]
        fn any_text_gives_a_view_or_an_error(text in "terrane:1/.*|.*") {
            if let Ok(line) = text.parse::<ViewLine>() {
                prop_assert_eq!(line.to_string().parse(), Ok(line));
            }
        }
    }
}
