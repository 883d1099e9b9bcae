//! Coordinate systems: degrees on any body, and all projections that proj4rs knows. In: an EPSG code, a proj string or WKT.
//! Out: true lengths and true directions around a place.
//!
//! Datums are not shifted into one another: degrees stay as they are.

use super::{wkt, Ellipsoid};
use crate::angles::sin_cos;
use proj4rs::transform::transform;
use proj4rs::Proj;
use std::f64::consts::PI;

/// Codes of systems in degrees whose files count in grads. (EPSG; the table has no units of angles.)
const IN_GRADS: [u16; 9] = [4807, 4810, 4811, 4816, 4819, 4821, 4901, 4902, 7400];

/// Parts of a proj string that shift datums or say nothing.
const LEFT_OUT: [&str; 7] = ["towgs84", "nadgrids", "geoidgrids", "no_defs", "wktext", "type", "vunits"];

/// Parts of a proj string that give a body its shape.
const SHAPE: [&str; 9] = ["R", "a", "b", "f", "rf", "es", "e", "ellps", "datum"];

/// Names of proj for systems in degrees.
const GEOGRAPHIC: [&str; 4] = ["longlat", "latlong", "lonlat", "latlon"];

/// A coordinate system.
pub(super) struct Crs {
    /// Its name in messages: its code, or its proj string.
    pub(super) name: String,
    pub(super) body: Ellipsoid,
    pub(super) kind: Kind,
    /// Metres a unit of height, if it says.
    pub(super) height_unit_m: Option<f64>,
    /// Whether its datum lies more than some metres beside WGS 84.
    pub(super) is_shifted: bool,
    /// The same as WKT, on one line, if a table or its owner gave that.
    pub(super) wkt: Option<String>,
}

/// What coordinates are.
pub(super) enum Kind {
    /// Angles of so many degrees, east of a meridian in degrees.
    Geographic { unit_deg: f64, meridian: f64 },
    /// Lengths in the plane.
    Projected(Box<Plane>),
}

/// A projection.
pub(super) struct Plane {
    projection: Proj,
    degrees: Proj,
    unit: &'static str,
    unit_m: f64,
}

/// What coordinates mean around a place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Local {
    /// Longitude and latitude, in degrees.
    pub(super) place: [f64; 2],
    /// Metres on the body a unit of the first and of the second coordinate.
    pub(super) metres: [f64; 2],
    /// Direction in which the second coordinate grows, in degrees clockwise from north.
    pub(super) heading: f64,
}

impl Crs {
    /// As a user names it.
    pub(super) fn of_user(text: &str) -> Result<Crs, String> {
        let text = text.trim();
        let number = text.strip_prefix("EPSG:").or(text.strip_prefix("epsg:")).unwrap_or(text);
        if let Ok(code) = number.parse::<u16>() {
            return Crs::of_code(code);
        }
        if text.contains("+proj=") {
            return Crs::of_proj(text, text);
        }
        if text.contains('[') {
            let proj = proj4wkt::wkt_to_projstring(text).map_err(|e| format!("WKT that cannot be read ({e:?})"))?;
            let wkt = Some(text.split_whitespace().collect::<Vec<_>>().join(" "));
            return Ok(Crs { wkt, ..Crs::of_proj(&proj, &proj)? });
        }
        Err(format!("'{text}'"))
    }

    /// By its EPSG code.
    pub(super) fn of_code(code: u16) -> Result<Crs, String> {
        let name = format!("EPSG:{code}");
        let Some(known) = crs_definitions::from_code(code) else { return Err(format!("{name}, which no table here has")) };
        let wkt = Some(known.wkt.trim().to_owned()).filter(|wkt| !wkt.is_empty());
        let mut crs = Crs { wkt, ..Crs::of_proj(known.proj4, &name)? };
        if let (true, Kind::Geographic { unit_deg, .. }) = (IN_GRADS.contains(&code), &mut crs.kind) {
            *unit_deg = 0.9;
        }
        Ok(crs)
    }

    /// By a proj string.
    pub(super) fn of_proj(text: &str, name: &str) -> Result<Crs, String> {
        let unknown = |what: &str| format!("{name} ({what})");
        let parts: Vec<(&str, &str)> =
            text.split_whitespace().map(|part| part.trim_start_matches('+').split_once('=').unwrap_or((part, ""))).collect();
        let value = |wanted: &str| parts.iter().find(|(key, _)| *key == wanted).map(|(_, value)| *value);
        let known = |keys: &[&str], wanted: bool| -> String {
            let part = |(key, value): &(&str, &str)| match (*key, *value) {
                // Its shift needs files that are not here; only its ellipsoid matters.
                ("datum", "NAD27") => "+ellps=clrk66".to_owned(),
                (key, "") => format!("+{}", key.trim_start_matches('+')),
                (key, value) => format!("+{key}={value}"),
            };
            let chosen = parts.iter().filter(|(key, _)| keys.contains(&key.trim_start_matches('+')) == wanted);
            chosen.map(part).collect::<Vec<_>>().join(" ")
        };
        let read = |text: &str| Proj::from_proj_string(text).map_err(|e| unknown(&e.to_string()));
        // Web Mercator takes degrees of WGS 84 for those of a sphere.
        let shape = if value("nadgrids") == Some("@null") { "+datum=WGS84".to_owned() } else { known(&SHAPE, true) };
        let body = shape_of(&shape).ok_or_else(|| unknown("no shape of a body"))?;
        let meridian = value("pm").map(|pm| format!("+pm={pm}")).unwrap_or_default();
        let projection = read(&known(&LEFT_OUT, false))?;
        let kind = if value("proj").is_some_and(|proj| GEOGRAPHIC.contains(&proj)) {
            Kind::Geographic { unit_deg: 1.0, meridian: degrees(projection.from_greenwich()) }
        } else if projection.has_inverse() && !projection.is_geocent() && projection.is_normalized_axis() {
            let degrees = read(&format!("+proj=longlat {} {meridian}", known(&SHAPE, true)))?;
            let (unit, unit_m) = (projection.units(), projection.to_meter());
            Kind::Projected(Box::new(Plane { projection, degrees, unit, unit_m }))
        } else {
            return Err(unknown("neither degrees nor a map with x to the east and y to the north"));
        };
        let height_unit_m = value("vunits").map(|unit| read(&format!("+proj=longlat +vunits={unit}"))).transpose()?;
        let height_unit_m = height_unit_m.map(|proj| proj.vto_meter());
        Ok(Crs { name: name.to_owned(), body, kind, height_unit_m, is_shifted: is_shifted(&value), wkt: None })
    }

    /// The same as WKT 1: as it was given, or made up for angles on a body of a size.
    pub(super) fn wkt(&self) -> Option<String> {
        let Kind::Geographic { unit_deg, meridian } = self.kind else { return self.wkt.clone() };
        Some(self.wkt.clone().unwrap_or_else(|| wkt::geographic(&self.body, meridian, unit_deg)))
    }

    /// The name of its unit.
    pub(super) fn unit(&self) -> String {
        match &self.kind {
            Kind::Geographic { unit_deg, .. } if *unit_deg == 1.0 => "degree".into(),
            Kind::Geographic { unit_deg, .. } => format!("angle of {unit_deg} degrees"),
            Kind::Projected(plane) => match plane.unit {
                "m" | "" => "metre".into(),
                "ft" => "foot".into(),
                "us-ft" => "US survey foot".into(),
                other => format!("{other} ({} m)", plane.unit_m),
            },
        }
    }

    /// Metres a unit by name, of a projection.
    pub(super) fn unit_m(&self) -> Option<f64> {
        match &self.kind {
            Kind::Geographic { .. } => None,
            Kind::Projected(plane) => Some(plane.unit_m),
        }
    }

    /// Longitude and latitude of a place, in degrees.
    pub(super) fn degrees(&self, [x, y]: [f64; 2]) -> Option<[f64; 2]> {
        match &self.kind {
            Kind::Geographic { unit_deg, meridian } => Some([x * unit_deg + meridian, y * unit_deg]),
            Kind::Projected(plane) => {
                let mut point = (x, y);
                transform(&plane.projection, &plane.degrees, &mut point).ok()?;
                let place = [degrees(point.0), degrees(point.1)];
                place.iter().all(|angle| angle.is_finite()).then_some(place)
            }
        }
    }

    /// The straight way from one place to another through the body, in metres.
    fn way(&self, to: [f64; 2], from: [f64; 2]) -> Option<[f64; 3]> {
        let (to, from) = (self.point(to)?, self.point(from)?);
        Some([0, 1, 2].map(|k| to[k] - from[k]))
    }

    /// A place on the body, in metres from its centre. Unlike degrees these have no seam, and no poles.
    fn point(&self, at: [f64; 2]) -> Option<[f64; 3]> {
        let [longitude, latitude] = self.degrees(at)?;
        let ((sin_lat, cos_lat), (sin_lon, cos_lon)) = (sin_cos(latitude), sin_cos(longitude));
        let squared = self.body.eccentricity_squared;
        let across = self.body.semi_major_m / (1.0 - squared * sin_lat * sin_lat).sqrt();
        Some([across * cos_lat * cos_lon, across * cos_lat * sin_lon, across * (1.0 - squared) * sin_lat])
    }

    /// Lengths and directions around a place, measured over `reach` units.
    pub(super) fn around(&self, [x, y]: [f64; 2], reach: f64) -> Option<Local> {
        let place = self.degrees([x, y])?;
        let across = self.way([x + reach, y], [x - reach, y])?;
        let along = self.way([x, y + reach], [x, y - reach])?;
        let length = |way: [f64; 3]| dot(way, way).sqrt() / (2.0 * reach);
        let metres = [length(across), length(along)];
        let ((sin_lat, cos_lat), (sin_lon, cos_lon)) = (sin_cos(place[1]), sin_cos(place[0]));
        let heading = dot(along, [-sin_lon, cos_lon, 0.0]).atan2(dot(along, [-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat]));
        let sound = metres.iter().all(|m| m.is_finite() && *m > 0.0);
        sound.then_some(Local { place, metres, heading: degrees(heading) })
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn degrees(radians: f64) -> f64 {
    radians * (180.0 / PI)
}

/// The body that parts of a proj string describe: from the places of its equator and of its pole.
fn shape_of(shape: &str) -> Option<Ellipsoid> {
    let [from, to] = ["longlat", "geocent"].map(|proj| Proj::from_proj_string(&format!("+proj={proj} {shape}")).ok());
    let (from, to) = (from?, to?);
    let place = |latitude: f64| {
        let mut point = (0.0, latitude, 0.0);
        transform(&from, &to, &mut point).ok().map(|()| point)
    };
    let (a, b) = (place(0.0)?.0, place(0.5 * PI)?.2);
    // To a hundredth of a millimetre, as ellipsoids are published: what platforms disagree about is far below.
    let [a, b] = [a, b].map(|m| (m * 1e5).round() / 1e5);
    let sound = (1.0..1e9).contains(&a) && (0.5..=1.0).contains(&(b / a));
    sound.then_some(Ellipsoid { semi_major_m: a, eccentricity_squared: 1.0 - (b / a) * (b / a) })
}

/// Whether a system's datum lies beside WGS 84 by more than elevation data resolves.
fn is_shifted<'a>(value: &impl Fn(&str) -> Option<&'a str>) -> bool {
    let moved = value("towgs84").is_some_and(|shift| {
        let metres = shift.split(',').take(3).filter_map(|part| part.parse::<f64>().ok());
        metres.map(f64::abs).fold(0.0, f64::max) > 10.0
    });
    let old = value("datum").is_some_and(|datum| !["WGS84", "NAD83"].contains(&datum));
    moved || old || value("nadgrids").is_some_and(|grid| grid != "@null")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(found: f64, expected: f64, off: f64) {
        assert!((found - expected).abs() <= off, "{found}, expected {expected}");
    }

    #[test]
    fn the_table_of_codes_can_be_read() {
        let codes = (1..=u16::MAX).filter(|&code| crs_definitions::from_code(code).is_some());
        let (known, unknown): (Vec<u16>, Vec<u16>) = codes.partition(|&code| Crs::of_code(code).is_ok());
        // Geocentric systems are no maps; the rest are two projections, and grids whose axes point elsewhere.
        assert!(known.len() > 5900, "{} systems are known", known.len());
        let maps = unknown.iter().filter(|&&c| !crs_definitions::from_code(c).is_some_and(|d| d.proj4.contains("geocent")));
        assert!(maps.count() < 60);
    }

    #[test]
    fn lengths_are_true() {
        // Web Mercator at 60 degrees; a unit is half a metre there, less the flattening.
        let merc = Crs::of_code(3857).unwrap().around([1e6, 8_399_738.0], 10.0).unwrap();
        near(merc.place[1], 60.0, 1e-5);
        near(merc.metres[0], 0.501_260, 1e-6);
        near(merc.metres[1], 0.500_420, 2e-3);
        // On the middle meridian of a UTM zone.
        let utm = Crs::of_code(32632).unwrap().around([5e5, 5.2e6], 10.0).unwrap();
        near(utm.metres[0], 1.0 / 0.9996, 1e-7);
        near(utm.metres[1], 1.0 / 0.9996, 1e-7);
        near(utm.heading, 0.0, 1e-7);
        // Feet of North Carolina.
        let feet = Crs::of_code(2264).unwrap();
        assert_eq!(feet.unit(), "US survey foot");
        near(feet.around([2e6, 6e5], 10.0).unwrap().metres[0], 0.304_801, 5e-5);
    }

    #[test]
    fn bodies_have_their_shape() {
        for (text, a, b) in [("+proj=longlat +R=1737400", 1_737_400.0, 1_737_400.0), ("EPSG:4267", 6_378_206.4, 6_356_583.8)] {
            let body = Crs::of_user(text).unwrap().body;
            near(body.semi_major_m, a, 1e-4);
            near(a * (1.0 - body.eccentricity_squared).sqrt(), b, 1e-3);
        }
        assert!(Crs::of_code(4267).unwrap().is_shifted && !Crs::of_code(4269).unwrap().is_shifted);
    }

    #[test]
    fn names_that_are_not_known_are_refused() {
        for name in ["EPSG:1", "moon", "+proj=nothing +R=1", "+proj=longlat +ellps=none", "GEOGCS[\"x\"]", "", "99999999"] {
            assert!(Crs::of_user(name).is_err(), "{name}");
        }
    }
}
