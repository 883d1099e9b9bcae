//! Numbers as text that is short enough for a panel.

/// Metres.
pub(super) fn distance(metres: f64) -> String {
    match metres.abs() {
        m if m < 100.0 => format!("{metres:.1} m"),
        m if m < 10e3 => format!("{metres:.0} m"),
        m if m < 1000e3 => format!("{:.1} km", metres / 1e3),
        _ => format!("{:.0} km", metres / 1e3),
    }
}

/// A count.
pub(super) fn count(number: u32) -> String {
    match number {
        n if n < 10_000 => n.to_string(),
        n if n < 1_000_000 => format!("{:.0} k", f64::from(n) / 1e3),
        n => format!("{:.2} M", f64::from(n) / 1e6),
    }
}

/// Degrees of latitude and longitude, with the letters of their ways.
pub(super) fn site([latitude, longitude]: [f64; 2]) -> String {
    let way = |degrees: f64, plus, minus| if degrees < 0.0 { minus } else { plus };
    format!("{:.5}° {}  {:.5}° {}", latitude.abs(), way(latitude, 'N', 'S'), longitude.abs(), way(longitude, 'E', 'W'))
}

/// Frames a second.
pub(super) fn rate(seconds: f64) -> String {
    match if seconds > 0.0 { 1.0 / seconds } else { 0.0 } {
        rate if rate < 9.95 => format!("{rate:.1} fps"),
        rate => format!("{rate:.0} fps"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let distances = [1.94, -1234.4, 56_780.0, 2e7].map(distance);
        assert_eq!(distances, ["1.9 m", "-1234 m", "56.8 km", "20000 km"]);
        assert_eq!([9_999, 123_456, 2_345_678].map(count), ["9999", "123 k", "2.35 M"]);
        assert_eq!(site([-38.95, 34.34]), "38.95000° S  34.34000° E");
        assert_eq!([0.0, 0.2, 0.01].map(rate), ["0.0 fps", "5.0 fps", "100 fps"]);
    }
}
