//! Where a mesh lies: the coordinates of its origin, for `--json`, for the extras of GLB files and for files beside a mesh.
//!
//! In: the georeference of a heightfield, or a point of a planet. Out: a system by name and as WKT 1, and the linear way from the metres
//! of a mesh to the coordinates of that system.

use super::Up;
use glam::DVec3;
use serde_json::{json, Value};
use terrane_heightfield::import::Georeference;

/// Where the origin of a mesh lies. A vertex x east, y north and z up (on a planet: in planet-fixed x, y, z), in metres, has the
/// coordinates `at + units_a_metre * (x, y, z)`.
#[derive(Clone, Debug, PartialEq)]
pub struct Origin {
    /// The system: `EPSG:32632`, or a proj string.
    pub crs: String,
    /// The same as WKT 1 on one line, where that is known.
    pub wkt: Option<String>,
    /// The unit of its first two coordinates, or on a planet of all three. Heights are metres.
    pub unit: String,
    /// Coordinates of the mesh's origin: east, north and height, or x, y and z.
    pub at: [f64; 3],
    /// Units of the system a metre of the mesh.
    pub units_a_metre: [f64; 3],
}

/// The two files beside a mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sidecar {
    /// `.txt`: axes, unit and origin, a line each.
    pub text: String,
    /// `.prj`: the system as WKT 1, or its proj string where no WKT is known; nothing without a system.
    pub projection: Option<String>,
}

impl Origin {
    /// The south-western sample of a heightfield of so many rows, with so many metres a sample east and north, at height 0.
    pub fn of_heightfield(place: &Georeference, rows: usize, spacing_m: [f64; 2]) -> Origin {
        let [west, north] = place.origin;
        Origin {
            // A user's own string may have ends of lines, which headers of files must not.
            crs: place.crs.split_whitespace().collect::<Vec<_>>().join(" "),
            wkt: place.wkt.clone(),
            unit: place.unit.clone(),
            at: [west, north - (rows as f64 - 1.0) * place.step[1], 0.0],
            units_a_metre: [place.step[0] / spacing_m[0], place.step[1] / spacing_m[1], 1.0],
        }
    }

    /// A point in planet-fixed metres from the centre of a planet whose datum is a sphere of a radius in metres.
    pub fn of_planet(radius: f64, at: DVec3) -> Origin {
        let sphere = format!("DATUM[\"D_sphere\",SPHEROID[\"sphere\",{radius},0]],PRIMEM[\"Reference_Meridian\",0]");
        let axes = "AXIS[\"Geocentric X\",OTHER],AXIS[\"Geocentric Y\",OTHER],AXIS[\"Geocentric Z\",NORTH]";
        Origin {
            crs: format!("+proj=geocent +R={radius} +units=m +no_defs"),
            wkt: Some(format!("GEOCCS[\"Planet-fixed, sphere of {radius} m\",{sphere},UNIT[\"metre\",1],{axes}]")),
            unit: "metre".into(),
            at: at.to_array(),
            units_a_metre: [1.0; 3],
        }
    }

    /// The same for programs.
    pub fn json(&self) -> Value {
        json!({
            "crs": self.crs, "wkt": self.wkt, "unit": self.unit, "origin": self.at, "units_a_metre": self.units_a_metre,
        })
    }

    /// The same in a few words.
    pub(super) fn words(&self) -> String {
        let [x, y, z] = self.at;
        format!("{x} {y} {z} in {}, unit {}", self.crs, self.unit)
    }
}

/// The files beside a mesh with an axis up, whose origin is there; `is_moved` if its file moves it there itself.
pub(super) fn sidecar(origin: Option<&Origin>, axes: &str, up: Up, is_moved: bool) -> Sidecar {
    let mut text = format!("axes: {axes}\n");
    let Some(origin) = origin else {
        text.push_str("crs: none is known\norigin: the south-west sample, at height 0\n");
        return Sidecar { text, projection: None };
    };
    let numbers = |three: [f64; 3]| three.map(|number| number.to_string()).join(" ");
    let vertex = match up {
        Up::Y => "(x, -z, y)",
        Up::Z => "(x, y, z)",
    };
    let moved = if is_moved { "; the translation of the node is this origin, and moves vertices there" } else { "" };
    text.push_str(&format!(
        "crs: {}\nunit: {}\norigin: {}\nunits a metre: {}\ncoordinates of a vertex: origin + units a metre * {vertex}{moved}\n",
        origin.crs,
        origin.unit,
        numbers(origin.at),
        numbers(origin.units_a_metre)
    ));
    let projection = origin.wkt.as_ref().unwrap_or(&origin.crs);
    Sidecar { text, projection: Some(format!("{projection}\n")) }
}
