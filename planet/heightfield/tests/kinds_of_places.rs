//! Kinds of files by where they lie: coordinate systems, units, bodies and the ways in which rows run.

use crate::kinds::{Case, Expect, Right};
use crate::tiff_file::{heights, Kind, TiffFile, Value, SIZE};
use terrane_heightfield::import::Options;

const F32: Kind = [32, 3];
const US_FOOT: f64 = 1200.0 / 3937.0;

/// Metres of a degree of longitude and of latitude on the Earth, by the series of the U.S. Hydrographic Office.
fn degree(latitude: f64) -> [f64; 2] {
    let c = |k: f64| (k * latitude.to_radians()).cos();
    [111_412.84 * c(1.0) - 93.5 * c(3.0) + 0.118 * c(5.0), 111_132.92 - 559.82 * c(2.0) + 1.175 * c(4.0) - 0.0023 * c(6.0)]
}

fn reads(spacing: [f64; 2]) -> Right {
    Right { size: SIZE, spacing: Some(spacing), corner: None, heights: [400.0, 800.0], levels: false, gaps: 0, notes: &[] }
}

/// A file in degrees: its north-western corner, and steps of an arc second.
fn second(north_west: [f64; 2]) -> TiffFile {
    TiffFile::floats().at(north_west, [1.0 / 3600.0; 2])
}

/// What is right of it: the length of a second in the middle, and the centre of the first sample.
fn second_is(latitude: f64, corner: [f64; 2]) -> Right {
    let middle = latitude - 32.0 / 3600.0;
    let half = 0.5 / 3600.0;
    Right { corner: Some([corner[0] + half, corner[1] - half]), ..reads(degree(middle).map(|d| d / 3600.0)) }
}

fn utm() -> TiffFile {
    TiffFile::floats().at([5e5, 52e5], [10.0; 2]).keys(&[(1024, 1), (1025, 1), (3072, 32_632), (3076, 9001)], &[])
}

/// The terrain with its rows or columns in the other order.
fn turned(rows: bool) -> Vec<u8> {
    let all = heights();
    let at = |c: usize, r: usize| if rows { all[(63 - r) * 96 + c] } else { all[r * 96 + 95 - c] };
    (0..96 * 64).flat_map(|i| (at(i % 96, i / 96) as f32).to_le_bytes()).collect()
}

fn matrix(file: TiffFile, [a, b, d, e]: [f64; 4], [x, y]: [f64; 2]) -> Vec<u8> {
    let rows = [a, b, 0.0, x, d, e, 0.0, y, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    file.keys(&[(1024, 1), (3072, 32_632)], &[]).tag(34_264, Value::Doubles(&rows)).bytes()
}

pub(crate) fn places() -> Vec<Case> {
    [degrees(), bodies(), projections(), units(), orders(), unknown()].into_iter().flatten().collect()
}

fn case(kind: &'static str, file: Vec<u8>, right: Right) -> Case {
    Case::new(kind, "a.tif", file, Expect::Reads(right))
}

fn refused(kind: &'static str, file: Vec<u8>, words: &'static [&'static str]) -> Case {
    Case::new(kind, "a.tif", file, Expect::Refused(words))
}

fn degrees() -> Vec<Case> {
    let at = [-84.0, 36.5];
    let in_degrees = |code: u16| second(at).keys(&[(1024, 2), (1025, 1), (2048, code), (2054, 9102)], &[]).bytes();
    let point = second(at).keys(&[(1024, 2), (1025, 2), (2048, 4326)], &[]).bytes();
    let grads = TiffFile::floats().at([0.0, 52.0], [0.001; 2]).keys(&[(1024, 2), (2048, 4807), (2054, 9105)], &[]).bytes();
    let radian = std::f64::consts::PI / 180.0;
    let radians = TiffFile::floats().at(at.map(|a| a * radian), [radian / 3600.0; 2]);
    let radians = radians.keys(&[(1024, 2), (2048, 4326), (2054, 9101)], &[]).bytes();
    let grad = 0.0009;
    let paris = Right {
        corner: Some([2.337_229 + 0.5 * grad, 46.8 - 0.5 * grad]),
        notes: &["is not shifted"],
        ..reads(degree(46.8 - 32.0 * grad).map(|d| d * grad))
    };
    let old = Right { notes: &["is not shifted"], ..second_is(36.5, at) };
    vec![
        case("GeoTIFF in degrees, WGS 84 (EPSG:4326)", in_degrees(4326), second_is(36.5, at)),
        case("GeoTIFF in degrees, NAD 83 (EPSG:4269)", in_degrees(4269), second_is(36.5, at)),
        case("GeoTIFF in degrees, ETRS 89 (EPSG:4258)", in_degrees(4258), second_is(36.5, at)),
        case("GeoTIFF in degrees, NAD 27 (EPSG:4267)", in_degrees(4267), old),
        case(
            "GeoTIFF in degrees, coordinates of samples (PixelIsPoint)",
            point,
            Right { corner: Some(at), ..second_is(36.5, at) },
        ),
        case("GeoTIFF in grads from Paris (EPSG:4807)", grads, paris),
        case("GeoTIFF in radians", radians, second_is(36.5, at)),
    ]
}

fn bodies() -> Vec<Case> {
    let moon = TiffFile::floats().at([10.0, 1.0], [0.01; 2]);
    let moon = moon.keys(&[(1024, 2), (2048, 32_767), (2050, 32_767), (2054, 9102)], &[(2057, 1_737_400.0), (2058, 1_737_400.0)]);
    let on_moon = 1_737_400.0 * std::f64::consts::PI / 180.0 * 0.01;
    let mars = TiffFile::floats().at([0.0, 320.0], [10.0; 2]).keys(
        &[(1024, 1), (2048, 32_767), (3072, 32_767), (3074, 32_767), (3075, 17), (3076, 9001)],
        &[(2057, 3_396_190.0), (2058, 3_396_190.0), (3078, 0.0), (3088, 0.0)],
    );
    let flat = TiffFile::floats().at([20.0, 0.32], [0.01; 2]);
    let flat = flat.keys(&[(1024, 2), (2048, 32_767), (2050, 32_767)], &[(2057, 3_396_190.0), (2059, 169.894_447)]);
    // At the equator of Mars a degree of latitude is shorter than one of longitude by twice the flattening.
    let on_mars = 3_396_190.0 * std::f64::consts::PI / 180.0 * 0.01;
    vec![
        case(
            "GeoTIFF in degrees on the Moon (radius in the file)",
            moon.bytes(),
            Right { corner: Some([10.005, 0.995]), ..reads([on_moon * 0.68_f64.to_radians().cos(), on_moon]) },
        ),
        case("GeoTIFF in metres on Mars (equirectangular, radius in the file)", mars.bytes(), reads([10.0; 2])),
        case(
            "GeoTIFF in degrees on Mars (flattened)",
            flat.bytes(),
            Right { corner: Some([20.005, 0.315]), ..reads([on_mars, on_mars * (1.0 - 1.0 / 169.894_447_f64).powi(2)]) },
        ),
    ]
}

fn projections() -> Vec<Case> {
    let metres = |code: u16, at: [f64; 2]| TiffFile::floats().at(at, [10.0; 2]).keys(&[(1024, 1), (3072, code)], &[]).bytes();
    let lambert = TiffFile::floats().at([7e5, 66e5], [10.0; 2]).keys(
        &[(1024, 1), (2048, 4171), (3072, 32_767), (3075, 8), (3076, 9001)],
        &[(3078, 49.0), (3079, 44.0), (3084, 3.0), (3085, 46.5), (3086, 7e5), (3087, 66e5)],
    );
    let zone = TiffFile::floats().at([5e5, 52e5], [10.0; 2]);
    let zone = zone.keys(&[(1024, 1), (2048, 4258), (3072, 32_767), (3074, 16_032), (3076, 9001)], &[]);
    // At the pole of EPSG:3031 the scale is 0.97276901: 71° south is true.
    let told = |right: Right| Right { notes: &["lengths on the ground are"], ..right };
    // Web Mercator at 60 degrees: degrees of WGS 84 drawn on a sphere.
    let unit = 180.0 / (std::f64::consts::PI * 6_378_137.0);
    let [east, north] = degree(60.0);
    let web = told(reads([10.0 * unit * east, 10.0 * unit * 0.5 * north]));
    // True Mercator is as long to the north as to the east.
    let world = told(reads([10.0 * unit * east; 2]));
    vec![
        case("GeoTIFF in metres of a UTM zone (EPSG:32632)", utm().bytes(), reads([10.0; 2])),
        case("GeoTIFF in a UTM zone, by numbers", zone.bytes(), reads([10.0; 2])),
        case("GeoTIFF in Web Mercator (EPSG:3857) at 60° north", metres(3857, [1e6, 8_400_058.0]), web),
        case("GeoTIFF in World Mercator (EPSG:3395) at 60° north", metres(3395, [1e6, 8_362_698.55 + 320.0]), world),
        case("GeoTIFF in Lambert 93 (EPSG:2154)", metres(2154, [7e5, 66e5]), reads([10.0; 2])),
        case("GeoTIFF in Lambert's cone, by numbers", lambert.bytes(), reads([10.0; 2])),
        case(
            "GeoTIFF in the British grid (EPSG:27700)",
            metres(27_700, [4e5, 3e5]),
            Right { notes: &["is not shifted"], ..reads([10.0; 2]) },
        ),
        case("GeoTIFF in Europe's equal areas (EPSG:3035)", metres(3035, [4_321_000.0, 3_210_000.0]), reads([10.0; 2])),
        case(
            "GeoTIFF in Antarctic stereographic (EPSG:3031), at the pole",
            metres(3031, [-480.0, 320.0]),
            told(reads([10.0 / 0.972_769_012_891_8; 2])),
        ),
    ]
}

fn units() -> Vec<Case> {
    let feet = |vertical: &[(u16, u16)]| {
        let keys = [&[(1024, 1), (1025, 1), (3072, 2264), (3076, 9003)], vertical].concat();
        TiffFile::floats().at([2e6, 6e5], [10.0; 2]).keys(&keys, &[]).bytes()
    };
    let international = TiffFile::floats().at([7e5, 8e5], [10.0; 2]).keys(&[(1024, 1), (3072, 2222), (3076, 9002)], &[]);
    let up = utm().keys(&[(1024, 1), (3072, 32_632), (4099, 9002)], &[]).bytes();
    let item =
        "<GDALMetadata>\n  <Item name=\"UNITTYPE\" sample=\"0\" role=\"unittype\">US survey foot</Item>\n</GDALMetadata>\n";
    let named = utm().tag(42_112, Value::Text(item)).bytes();
    let turned: &[&str] = &["are turned into metres"];
    vec![
        case(
            "GeoTIFF in US survey feet (EPSG:2264), heights without a unit",
            feet(&[]),
            Right { notes: &["states no unit of heights"], ..reads([10.0 * US_FOOT; 2]) },
        ),
        case(
            "GeoTIFF in US survey feet, heights too",
            feet(&[(4099, 9003)]),
            Right { notes: turned, heights: [400.0, 800.0].map(|h| h * US_FOOT), ..reads([10.0 * US_FOOT; 2]) },
        ),
        case(
            "GeoTIFF in international feet (EPSG:2222)",
            international.bytes(),
            Right { notes: &["states no unit of heights"], ..reads([3.048; 2]) },
        ),
        case(
            "GeoTIFF in metres, heights in feet (vertical unit)",
            up,
            Right { notes: turned, heights: [121.92, 243.84], ..reads([10.0; 2]) },
        ),
        case(
            "GeoTIFF in metres, heights in feet (unit of the band)",
            named,
            Right { notes: turned, heights: [400.0, 800.0].map(|h| h * US_FOOT), ..reads([10.0; 2]) },
        ),
    ]
}

fn orders() -> Vec<Case> {
    let lean = [8.660_254_037_844_387, 5.0, 5.0, -8.660_254_037_844_387];
    vec![
        case(
            "GeoTIFF with its south up",
            matrix(TiffFile::new(SIZE, F32, turned(true)), [10.0, 0.0, 0.0, 10.0], [5e5, 5_199_360.0]),
            reads([10.0; 2]),
        ),
        case(
            "GeoTIFF with its east on the left",
            matrix(TiffFile::new(SIZE, F32, turned(false)), [-10.0, 0.0, 0.0, -10.0], [500_960.0, 52e5]),
            reads([10.0; 2]),
        ),
        refused(
            "GeoTIFF that is turned by 30°",
            matrix(TiffFile::floats(), lean, [5e5, 52e5]),
            &["turned by 30.000 degrees", "gdalwarp", "--spacing"],
        ),
        refused(
            "GeoTIFF with ground control points",
            TiffFile::floats().tag(33_922, Value::Doubles(&[0.0; 18])).keys(&[(1024, 2), (2048, 4326)], &[]).bytes(),
            &["3 ground control points", "gdalwarp"],
        ),
    ]
}

fn unknown() -> Vec<Case> {
    let placed = |codes: &[(u16, u16)]| TiffFile::floats().at([5e5, 52e5], [10.0; 2]).keys(codes, &[]).bytes();
    let named = TiffFile::floats().at([5e5, 52e5], [10.0; 2]).tag(34_737, Value::Text("Our own grid|"));
    let named = named.tag(34_735, Value::Shorts(&[1, 1, 0, 3, 1024, 0, 1, 1, 1026, 34_737, 13, 0, 3072, 0, 1, 32_767]));
    let bare = || TiffFile::floats().at([5e5, 52e5], [10.0; 2]).bytes();
    let crs = Options { crs: Some("EPSG:32632".into()), ..Options::default() };
    let proj = Options { crs: Some("+proj=tmerc +lon_0=9 +k=0.9996 +x_0=500000 +units=us-ft".into()), ..Options::default() };
    vec![
        refused("GeoTIFF of an unknown code", placed(&[(1024, 1), (3072, 5)]), &["EPSG:5", "--crs", "--spacing"]),
        refused("GeoTIFF of a system that only its name tells", named.bytes(), &["Our own grid", "--crs"]),
        refused("GeoTIFF with a place but no coordinate system", bare(), &["no coordinate system", "--crs"]),
        case("the same", bare(), reads([10.0; 2])).with("--crs EPSG:32632", crs),
        case("the same", bare(), Right { notes: &["states no unit of heights"], ..reads([10.0 * US_FOOT; 2]) })
            .with("--crs '+proj=tmerc …'", proj),
        refused(
            "GeoTIFF whose unit is not that of its code",
            placed(&[(1024, 1), (3072, 2264), (3076, 9001)]),
            &["EPSG:2264", "a unit of 1 m"],
        ),
        refused("GeoTIFF in geocentric metres", placed(&[(1024, 3)]), &["geocentric"]),
        refused(
            "GeoTIFF whose degrees lie beside the globe",
            placed(&[(1024, 2), (2048, 4326)]),
            &["EPSG:4326 from longitude", "on a globe"],
        ),
        case("TIFF that says nothing about its place", TiffFile::floats().bytes(), Right { spacing: None, ..reads([1.0; 2]) }),
    ]
}
