//! Wavefront OBJ: text, exact decimals, one object of triangles, normals to six digits.

use super::{Model, Up};
use std::fmt::Write;

/// The bytes of a file.
pub(super) fn encode(mesh: &Model, up: Up) -> Vec<u8> {
    let mut text = format!("# Terrane: {}\n# {}\no terrane\n", mesh.axes(up), mesh.provenance);
    for &position in &mesh.positions {
        text.push('v');
        for metres in up.turn(position).to_array() {
            text.push(' ');
            push_decimal(&mut text, metres, mesh.decimals);
        }
        text.push('\n');
    }
    // Writing to a string cannot fail.
    for &normal in &mesh.normals {
        let n = up.turn(normal).as_vec3();
        let _ = writeln!(text, "vn {} {} {}", n.x, n.y, n.z);
    }
    for triangle in mesh.triangles.iter() {
        let [a, b, c] = triangle.map(|v| u64::from(v) + 1);
        let _ = if mesh.normals.is_empty() {
            writeln!(text, "f {a} {b} {c}")
        } else {
            writeln!(text, "f {a}//{a} {b}//{b} {c}//{c}")
        };
    }
    text.into_bytes()
}

/// Decimals that a multiple of a power of two can have.
pub(super) fn decimals(unit: f64) -> usize {
    (-unit.log2()).max(0.0) as usize
}

/// All digits of a number, without zeros at the end: so many decimals print a multiple of the unit as it is. Without a number
/// of decimals the fewest digits that read back as the same double.
fn push_decimal(text: &mut String, number: f64, decimals: Option<usize>) {
    let Some(decimals) = decimals else {
        let _ = write!(text, "{number}");
        return;
    };
    let _ = write!(text, "{number:.decimals$}");
    if decimals > 0 {
        text.truncate(text.trim_end_matches('0').trim_end_matches('.').len());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimals_are_exact() {
        let written = |number, unit: f64| {
            let mut text = String::new();
            push_decimal(&mut text, number, Some(decimals(unit)));
            text
        };
        assert_eq!(written(-1.0 / 128.0, 1.0 / 128.0), "-0.0078125");
        assert_eq!(written(6_371_000.5, 1.0 / 128.0), "6371000.5");
        assert_eq!(written(100.0, 1.0 / 128.0), "100");
        assert_eq!(written(100.0, 4.0), "100");
        // More digits than a shortest round trip would show.
        let unit = 2f64.powi(-20);
        assert_eq!(written(16_385.0 + unit, unit), "16385.00000095367431640625");
    }
}
