//! Times as a year, a day of it and a minute of that, in UTC: what sliders can choose. In and out: seconds since 1970.

use jiff::civil::Date;
use jiff::tz::TimeZone;
use jiff::{Timestamp, ToSpan};

/// Years that can be chosen: those for which the sun's place is good ([`terrane_planet::globe::sun`]).
pub(super) const YEARS: std::ops::RangeInclusive<i16> = 1700..=2300;
/// Minutes of a day.
pub(super) const MINUTES: u16 = 24 * 60;

/// A minute.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Moment {
    pub(super) year: i16,
    /// Day of the year, from 1.
    pub(super) day: u16,
    /// Minute of the day.
    pub(super) minute: u16,
}

impl Moment {
    /// The minute that holds a second, or the nearest that can be chosen.
    pub(super) fn of(seconds: i64) -> Moment {
        let time = Timestamp::from_second(seconds).unwrap_or(Timestamp::UNIX_EPOCH).to_zoned(TimeZone::UTC);
        Moment {
            year: time.year().clamp(*YEARS.start(), *YEARS.end()),
            day: time.day_of_year().unsigned_abs(),
            minute: (60 * i16::from(time.hour()) + i16::from(time.minute())).unsigned_abs(),
        }
    }

    /// This minute.
    pub(super) fn now() -> Moment {
        Moment::of(Timestamp::now().as_second())
    }

    /// Seconds since 1970.
    pub(super) fn seconds(self) -> i64 {
        let minute = i64::from(self.minute.min(MINUTES - 1));
        self.date().to_zoned(TimeZone::UTC).map_or(0, |midnight| midnight.timestamp().as_second()) + 60 * minute
    }

    /// Days of the year.
    pub(super) fn days(self) -> u16 {
        first_day(self.year).days_in_year().unsigned_abs()
    }

    /// The day, such as "21 June".
    pub(super) fn day_name(self) -> String {
        self.date().strftime("%-d %B").to_string()
    }

    /// The time of day, such as "09:05".
    pub(super) fn clock(self) -> String {
        format!("{:02}:{:02}", self.minute / 60, self.minute % 60)
    }

    fn date(self) -> Date {
        let day = self.day.clamp(1, self.days());
        first_day(self.year).checked_add((i32::from(day) - 1).days()).unwrap_or(Date::ZERO)
    }
}

fn first_day(year: i16) -> Date {
    Date::new(year.clamp(*YEARS.start(), *YEARS.end()), 1, 1).unwrap_or(Date::ZERO)
}

/// The minute of the day that a text such as "9:05" or "21" says.
pub(super) fn parse_clock(text: &str) -> Option<u16> {
    let (hour, minute) = text.trim().split_once(':').unwrap_or((text.trim(), "0"));
    let (hour, minute): (u16, u16) = (hour.parse().ok()?, minute.parse().ok()?);
    (hour < 24 && minute < 60).then_some(60 * hour + minute)
}

/// The day of a year that a text such as "21 June" says.
pub(super) fn parse_day(year: i16, text: &str) -> Option<u16> {
    let date = Date::strptime("%Y %d %B", format!("{year} {}", text.trim())).ok()?;
    Some(date.day_of_year().unsigned_abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_moment_is_the_minute_of_its_second() {
        // 2026-06-21T12:34:56Z.
        let moment = Moment::of(1_782_045_296);
        assert_eq!(moment, Moment { year: 2026, day: 172, minute: 12 * 60 + 34 });
        assert_eq!((moment.seconds(), moment.day_name().as_str(), moment.clock().as_str()), (1_782_045_240, "21 June", "12:34"));
        assert_eq!([2024, 2026].map(|year| Moment { year, ..moment }.days()), [366, 365]);
        assert_eq!(Moment { year: 2026, day: 366, minute: 0 }.day_name(), "31 December");
    }

    #[test]
    fn what_is_written_is_read() {
        for seconds in [0, 951_782_400, 1_782_045_240] {
            let moment = Moment::of(seconds);
            assert_eq!(parse_day(moment.year, &moment.day_name()), Some(moment.day));
            assert_eq!(parse_clock(&moment.clock()), Some(moment.minute));
            assert_eq!(moment.seconds(), seconds);
        }
        assert_eq!(["9:05", "21", "24:00", "x", "12:60"].map(parse_clock), [Some(545), Some(1260), None, None, None]);
        assert_eq!(parse_day(2026, "30 February"), None);
    }
}
