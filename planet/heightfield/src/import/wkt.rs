//! Systems of angles as WKT 1 (OGC 01-009), for bodies and units that no table has.

use super::Ellipsoid;
use std::f64::consts::PI;

/// Flattenings below this are those of spheres, which WKT writes as an inverse of 0.
const FLAT: f64 = 1e-12;

/// A system of angles of so many degrees, east of a meridian in degrees, which stays in degrees, as GDAL writes it.
pub(super) fn geographic(body: &Ellipsoid, meridian: f64, unit_deg: f64) -> String {
    let (a, inverse) = (body.semi_major_m, inverse_flattening(body));
    let unit = match unit_deg {
        1.0 => "degree".to_owned(),
        other => format!("{other} degrees"),
    };
    let meridian_name = if meridian == 0.0 { "Reference_Meridian" } else { "Shifted_Meridian" };
    format!(
        "GEOGCS[\"Body of {a} m\",DATUM[\"D_unnamed\",SPHEROID[\"unnamed\",{a},{inverse}]],\
         PRIMEM[\"{meridian_name}\",{}],UNIT[\"{unit}\",{}]]",
        meridian,
        unit_deg * PI / 180.0
    )
}

/// To nine digits after the point, as ellipsoids are published; 0 for a sphere.
fn inverse_flattening(body: &Ellipsoid) -> f64 {
    let flattening = 1.0 - (1.0 - body.eccentricity_squared).sqrt();
    if flattening < FLAT {
        0.0
    } else {
        (1e9 / flattening).round() / 1e9
    }
}

#[cfg(test)]
mod tests {
    use super::super::crs::Crs;

    /// What the table, a proj string or a user gives comes back from its own WKT with the same body and the same coordinates.
    #[test]
    fn systems_come_back_from_their_wkt() {
        for name in [
            "EPSG:4326",
            "EPSG:4269",
            "EPSG:32632",
            "EPSG:2264",
            "+proj=longlat +R=1737400",
            "+proj=longlat +a=3396190 +b=3376200",
        ] {
            let crs = Crs::of_user(name).unwrap();
            let back = Crs::of_user(&crs.wkt().unwrap()).unwrap();
            assert!((crs.body.semi_major_m - back.body.semi_major_m).abs() < 1e-3, "{name}");
            assert!((crs.body.eccentricity_squared - back.body.eccentricity_squared).abs() < 1e-9, "{name}");
            let place = if crs.unit_m().is_some() { [5.2e5, 5.3e6] } else { [-81.5, 35.25] };
            let place = if name == "EPSG:2264" { [1.5e6, 6e5] } else { place };
            let [a, b] = [crs.degrees(place).unwrap(), back.degrees(place).unwrap()];
            assert!((a[0] - b[0]).abs() < 1e-7 && (a[1] - b[1]).abs() < 1e-7, "{name}: {a:?}, {b:?}");
        }
        assert!(Crs::of_user("EPSG:32632").unwrap().wkt().unwrap().contains("UTM zone 32N"));
        assert_eq!(Crs::of_user("+proj=utm +zone=32 +ellps=GRS80").unwrap().wkt(), None, "no table has it");
    }
}
