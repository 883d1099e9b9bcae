//! The keys of a GeoTIFF (OGC GeoTIFF 1.1, 2019) as a coordinate system. What they say by code comes from the table of codes;
//! what they say by numbers becomes a proj string.

use super::crs::{Crs, Kind};

/// Keys.
const MODEL_TYPE: u16 = 1024;
const RASTER_TYPE: u16 = 1025;
const CITATIONS: [u16; 3] = [3073, 1026, 2049];
const GEODETIC: u16 = 2048;
const DATUM: u16 = 2050;
const PRIME_MERIDIAN: u16 = 2051;
const ANGULAR_UNIT: u16 = 2054;
const SEMI_MAJOR: u16 = 2057;
const SEMI_MINOR: u16 = 2058;
const INVERSE_FLATTENING: u16 = 2059;
const MERIDIAN_LONGITUDE: u16 = 2061;
const PROJECTED: u16 = 3072;
const PROJECTION: u16 = 3074;
const METHOD: u16 = 3075;
const LINEAR_UNIT: u16 = 3076;
const LINEAR_UNIT_M: u16 = 3077;
const VERTICAL: u16 = 4096;
const VERTICAL_UNIT: u16 = 4099;

/// What stands for a system by numbers.
const USER_DEFINED: u16 = 32_767;

/// The directory of keys, with the numbers and the text that they refer to.
pub(super) struct GeoKeys {
    pub(super) directory: Vec<u16>,
    pub(super) doubles: Vec<f64>,
    pub(super) text: String,
}

impl GeoKeys {
    fn entry(&self, wanted: u16) -> Option<&[u16]> {
        self.directory.chunks_exact(4).skip(1).find(|entry| entry[0] == wanted)
    }

    /// The value of a key that is stored in the directory itself.
    fn code(&self, wanted: u16) -> Option<u16> {
        self.entry(wanted).filter(|entry| entry[1] == 0).map(|entry| entry[3])
    }

    /// A code that stands in a table.
    fn table_code(&self, wanted: u16) -> Option<u16> {
        self.code(wanted).filter(|code| !matches!(*code, 0 | USER_DEFINED))
    }

    fn number(&self, wanted: u16) -> Option<f64> {
        let entry = self.entry(wanted).filter(|entry| entry[1] == 34_736)?;
        self.doubles.get(usize::from(entry[3])).copied().filter(|n| n.is_finite())
    }

    fn string(&self, wanted: u16) -> Option<&str> {
        let entry = self.entry(wanted).filter(|entry| entry[1] == 34_737)?;
        let (start, length) = (usize::from(entry[3]), usize::from(entry[2]));
        let text = self.text.get(start..(start + length).min(self.text.len()))?.trim_matches(['|', '\0', ' ']);
        Some(text).filter(|text| !text.is_empty() && *text != "unknown")
    }

    /// Whether coordinates are those of samples, not of the corners of areas around them.
    pub(super) fn is_point(&self) -> bool {
        self.code(RASTER_TYPE) == Some(2)
    }

    /// Whether nothing is said.
    pub(super) fn is_empty(&self) -> bool {
        self.directory.len() < 8
    }

    /// The coordinate system, or the name of what is not understood.
    pub(super) fn crs(&self) -> Result<Crs, String> {
        let named = |error: String| match CITATIONS.iter().find_map(|&key| self.string(key)) {
            Some(citation) if !error.contains(citation) => format!("{error}, called '{citation}'"),
            _ => error,
        };
        match self.code(MODEL_TYPE) {
            Some(1) => self.projected().map_err(named),
            Some(2) => self.geographic().map_err(named),
            Some(3) => Err(named("a geocentric system".into())),
            _ => Err(named("no coordinate system".into())),
        }
    }

    /// Metres a unit of height, if the keys say: by their unit, or by the code of the vertical system.
    pub(super) fn height_unit_m(&self) -> Result<Option<f64>, String> {
        match (self.table_code(VERTICAL_UNIT), self.table_code(VERTICAL)) {
            (Some(code), _) => length_m(code).map(Some).ok_or_else(|| format!("heights in unit {code}")),
            // NAVD 88 and others in US survey feet, and in feet.
            (None, Some(6360 | 6358 | 6357)) => Ok(Some(US_FOOT_M)),
            (None, Some(8228 | 8050 | 8051 | 8052)) => Ok(Some(FOOT_M)),
            (None, _) => Ok(None),
        }
    }

    fn geographic(&self) -> Result<Crs, String> {
        let mut crs = match self.table_code(GEODETIC) {
            Some(code) => Crs::of_code(code)?,
            None => {
                let text = format!("+proj=longlat {}", self.shape()?);
                Crs::of_proj(&text, &text)?
            }
        };
        match (self.table_code(ANGULAR_UNIT), &mut crs.kind) {
            (Some(code), Kind::Geographic { unit_deg, .. }) => {
                let stated = angle_deg(code).ok_or_else(|| format!("angles in unit {code}"))?;
                // What the table says is then of another unit.
                crs.wkt = crs.wkt.filter(|_| stated == *unit_deg);
                *unit_deg = stated;
            }
            (None, Kind::Geographic { .. }) => (),
            (_, Kind::Projected(_)) => return Err(format!("{}, which is not in degrees", crs.name)),
        }
        Ok(crs)
    }

    /// The body and the prime meridian of a system, as parts of a proj string.
    fn shape(&self) -> Result<String, String> {
        // Codes of datums are those of their systems in degrees, and 2000.
        let code = self.table_code(GEODETIC).or(self.table_code(DATUM).and_then(|datum| datum.checked_sub(2000)));
        if let Some(known) = code.and_then(crs_definitions::from_code) {
            return Ok(known.proj4.replace("+proj=longlat", "").replace("+no_defs", "").trim().to_owned());
        }
        let Some(a) = self.number(SEMI_MAJOR) else { return Err("a body whose size is not stated".into()) };
        let shape = match (self.number(INVERSE_FLATTENING), self.number(SEMI_MINOR)) {
            (Some(inverse), _) if inverse > 1.0 => format!("+a={a} +rf={inverse}"),
            (_, Some(b)) if b != a => format!("+a={a} +b={b}"),
            _ => format!("+R={a}"),
        };
        match (self.number(MERIDIAN_LONGITUDE), self.table_code(PRIME_MERIDIAN)) {
            (Some(longitude), _) if longitude != 0.0 => Ok(format!("{shape} +pm={longitude}")),
            (None, Some(code)) if code != 8901 => Err(format!("prime meridian {code}")),
            _ => Ok(shape),
        }
    }

    fn projected(&self) -> Result<Crs, String> {
        let unit_m = match (self.code(LINEAR_UNIT), self.number(LINEAR_UNIT_M)) {
            (Some(USER_DEFINED), Some(metres)) if metres > 0.0 => Some(metres),
            (Some(0) | None, _) => None,
            (Some(code), _) => Some(length_m(code).ok_or_else(|| format!("lengths in unit {code}"))?),
        };
        if let Some(code) = self.table_code(PROJECTED) {
            let crs = Crs::of_code(code)?;
            return match (unit_m, crs.unit_m()) {
                (_, None) => Err(format!("{}, which is no projection", crs.name)),
                (Some(stated), Some(own)) if (stated / own - 1.0).abs() > 1e-9 => {
                    Err(format!("{} in {}, but a unit of {stated} m", crs.name, crs.unit()))
                }
                _ => Ok(crs),
            };
        }
        let unit_m = unit_m.unwrap_or(1.0);
        let text = format!("{} {} +to_meter={unit_m}", self.method(unit_m)?, self.shape()?);
        let text = text.replace(" +to_meter=1", "").replace(&format!("+to_meter={US_FOOT_M}"), "+units=us-ft");
        Crs::of_proj(&text.replace(&format!("+to_meter={FOOT_M}"), "+units=ft"), &text)
    }

    /// The first of some keys that has a number, or 0.
    fn first(&self, keys: &[u16]) -> f64 {
        keys.iter().find_map(|&key| self.number(key)).unwrap_or(0.0)
    }

    /// The projection as a part of a proj string.
    fn method(&self, unit_m: f64) -> Result<String, String> {
        if let Some(utm) = self.table_code(PROJECTION) {
            return match utm {
                16_001..=16_060 => Ok(format!("+proj=utm +zone={}", utm - 16_000)),
                16_101..=16_160 => Ok(format!("+proj=utm +zone={} +south", utm - 16_100)),
                _ => Err(format!("projection {utm}")),
            };
        }
        let angle = self.table_code(ANGULAR_UNIT).map_or(Some(1.0), angle_deg).ok_or("angles in an unknown unit")?;
        let lon = angle * self.first(&[3080, 3084, 3088, 3095]);
        let lat = angle * self.first(&[3081, 3085, 3089]);
        let [first, second] = [3078, 3079].map(|key| angle * self.first(&[key]));
        let x = unit_m * self.first(&[3082, 3086, 3090]);
        let y = unit_m * self.first(&[3083, 3087, 3091]);
        let k = self.number(3092).or(self.number(3093)).unwrap_or(1.0);
        let shift = format!("+x_0={x} +y_0={y}");
        let Some(method) = self.code(METHOD) else { return Err("a projection that is not stated".into()) };
        Ok(match method {
            1 => format!("+proj=tmerc +lat_0={lat} +lon_0={lon} +k={k} {shift}"),
            7 if self.number(3078).is_some() => format!("+proj=merc +lat_ts={first} +lon_0={lon} {shift}"),
            7 => format!("+proj=merc +lon_0={lon} +k={k} {shift}"),
            8 => format!("+proj=lcc +lat_1={first} +lat_2={second} +lat_0={lat} +lon_0={lon} {shift}"),
            9 => format!("+proj=lcc +lat_1={lat} +lat_0={lat} +lon_0={lon} +k_0={k} {shift}"),
            10 => format!("+proj=laea +lat_0={lat} +lon_0={lon} {shift}"),
            11 => format!("+proj=aea +lat_1={first} +lat_2={second} +lat_0={lat} +lon_0={lon} {shift}"),
            12 => format!("+proj=aeqd +lat_0={lat} +lon_0={lon} {shift}"),
            // By a true parallel where that is meant: a pole has the scale 1 or a little less.
            15 if lat.abs() < 90.0 => {
                let pole = if lat < 0.0 { -90 } else { 90 };
                format!("+proj=stere +lat_0={pole} +lat_ts={lat} +lon_0={lon} {shift}")
            }
            14 | 15 => format!("+proj=stere +lat_0={lat} +lon_0={lon} +k={k} {shift}"),
            16 => format!("+proj=sterea +lat_0={lat} +lon_0={lon} +k={k} {shift}"),
            17 => format!("+proj=eqc +lat_ts={first} +lat_0={lat} +lon_0={lon} {shift}"),
            18 => format!("+proj=cass +lat_0={lat} +lon_0={lon} {shift}"),
            21 => format!("+proj=ortho +lat_0={lat} +lon_0={lon} {shift}"),
            22 => format!("+proj=poly +lat_0={lat} +lon_0={lon} {shift}"),
            23 => format!("+proj=robin +lon_0={lon} {shift}"),
            24 => format!("+proj=sinu +lon_0={lon} {shift}"),
            28 => format!("+proj=cea +lat_ts={first} +lon_0={lon} {shift}"),
            other => return Err(format!("projection method {other}")),
        })
    }
}

/// An international foot and a US survey foot, in metres.
pub(super) const FOOT_M: f64 = 0.3048;
pub(super) const US_FOOT_M: f64 = 1200.0 / 3937.0;

/// Metres of a unit of length.
fn length_m(code: u16) -> Option<f64> {
    match code {
        9001 => Some(1.0),
        9002 => Some(FOOT_M),
        9003 => Some(US_FOOT_M),
        9005 => Some(0.304_797_265_4),
        9036 => Some(1000.0),
        1025 => Some(0.001),
        1033 => Some(0.01),
        _ => None,
    }
}

/// Degrees of a unit of angles.
fn angle_deg(code: u16) -> Option<f64> {
    match code {
        9101 => Some(180.0 / std::f64::consts::PI),
        9102 | 9122 => Some(1.0),
        9103 => Some(1.0 / 60.0),
        9104 => Some(1.0 / 3600.0),
        9105 | 9106 => Some(0.9),
        _ => None,
    }
}
