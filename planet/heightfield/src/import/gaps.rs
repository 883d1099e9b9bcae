//! Samples without data: those that a file or its owner declares, and numbers that look like it: written in place of data but not
//! declared, or no heights at all.

use super::options::NoData;
use super::{Georeference, Imported, Source, Values};

/// Numbers that programs write where there is no data. Floats of such size, and everything beyond, count too.
const SENTINELS: [f32; 8] = [-9999.0, -32_768.0, -32_767.0, 32_767.0, -99_999.0, -999_999.0, 9999.0, 99_999.0];
const LARGEST: f32 = 1e30;

/// How far beyond all other heights such a number must lie, in metres; and beyond their range as often as it is high.
const APART_M: f32 = 1000.0;

/// Highest and lowest ground of bodies of the Earth's size, in metres.
const HIGHEST_M: f32 = 12_000.0;

/// Spreads from the median beyond which a height is impossible on other bodies, too; and how many samples tell the spread.
const MOST_SPREADS: f32 = 50.0;
const PROBES: usize = 1 << 16;

/// Which numbers stand for no data.
pub(super) struct Gaps {
    declared: [Option<f64>; 2],
}

impl Gaps {
    pub(super) fn new(source: &Source, declared: Option<f64>) -> Gaps {
        let stated = match source.options.no_data {
            Some(NoData::Value(value)) => Some(value),
            Some(NoData::Declared) | None => None,
        };
        Gaps { declared: [declared, stated] }
    }

    /// Whether a number stands for no data. NaN always does.
    pub(super) fn holds(&self, number: f64, floats: bool) -> bool {
        // Declared in decimals, which may round to the float next to the one that is meant: compare as floats.
        let same = |declared: f64| declared == number || floats && declared as f32 == number as f32;
        number.is_nan() || self.declared.iter().flatten().any(|&declared| same(declared))
    }
}

/// Takes numbers that stand for no data out of an image, though nobody declared them, and tells of heights that cannot be.
pub(super) fn look_at(image: &mut Imported, asked: Option<NoData>) {
    if !matches!(image.values, Values::Metres) || image.no_data == image.field.heights().len() {
        return;
    }
    if asked != Some(NoData::Declared) {
        while let Some(number) = undeclared(image) {
            let (count, place) = count(image, |h| h == number || number.abs() >= LARGEST && h.abs() >= LARGEST);
            take_out(image, number);
            let stay = "`--no-data declared` keeps them";
            // A float's digits beyond the seventh say nothing.
            let number = if number.abs() >= 1e7 { format!("{number:e}") } else { number.to_string() };
            image
                .notes
                .push(format!("{count} samples of {number} ({place}) are no heights, though undeclared: taken as gaps ({stay})"));
        }
    }
    let limits = limits(image);
    let outside = |h: f32| h < limits[0] || h > limits[1];
    if image.range.iter().any(|&h| outside(h)) {
        let (count, place) = count(image, outside);
        image.notes.push(format!(
            "{count} heights are hardly possible, from {} to {} m ({place}): name what stands for no data (--no-data V)",
            image.range[0], image.range[1]
        ));
    }
}

/// A number at an end of the range that stands for no data.
fn undeclared(image: &Imported) -> Option<f32> {
    let suspect = |end: f32| SENTINELS.contains(&end) || end.abs() >= LARGEST;
    image.range.into_iter().find(|&end| suspect(end) && lies_apart(image, end))
}

/// Whether all other heights lie far from a number, and there are some.
fn lies_apart(image: &Imported, number: f32) -> bool {
    let other = |h: &&f32| !h.is_nan() && **h != number && !(number.abs() >= LARGEST && h.abs() >= LARGEST);
    let ends = (f32::INFINITY, f32::NEG_INFINITY);
    let (low, high) = image.field.heights().iter().filter(other).fold(ends, |(l, h), &x| (l.min(x), h.max(x)));
    // A second such number at the other end tells nothing about the range.
    let range = if SENTINELS.contains(&low) || SENTINELS.contains(&high) || high.abs().max(low.abs()) >= LARGEST {
        0.0
    } else {
        high - low
    };
    low <= high && (low - number).max(number - high) > range.max(APART_M)
}

fn take_out(image: &mut Imported, number: f32) {
    let gone = |h: f32| h == number || number.abs() >= LARGEST && h.abs() >= LARGEST;
    let mut heights = std::mem::take(&mut image.field.heights);
    heights.iter_mut().filter(|h| gone(**h)).for_each(|h| *h = f32::NAN);
    image.field.heights = heights;
    image.count();
}

/// How many samples are so, and where the first is.
fn count(image: &Imported, is_so: impl Fn(f32) -> bool) -> (usize, String) {
    let heights = image.field.heights();
    let first = heights.iter().position(|&h| is_so(h)).unwrap_or(0);
    let place = format!("the first at column {}, row {}", first % image.field.columns(), first / image.field.columns());
    (heights.iter().filter(|&&h| is_so(h)).count(), place)
}

/// Heights that are possible.
fn limits(image: &Imported) -> [f32; 2] {
    let heights = image.field.heights();
    let stride = heights.len().div_ceil(PROBES);
    let mut probes: Vec<f32> = heights.iter().copied().step_by(stride).filter(|h| !h.is_nan()).collect();
    probes.sort_by(f32::total_cmp);
    let at = |share: f64| probes.get((share * (probes.len().max(1) - 1) as f64) as usize).copied().unwrap_or(0.0);
    // As many spreads as lie between the hundredths of a bell curve: single wild samples do not widen it.
    let (median, spread) = (at(0.5), (at(0.99) - at(0.01)) / 4.65);
    let far = if spread > 0.0 { MOST_SPREADS * spread } else { f32::INFINITY };
    let earth = |place: &Georeference| place.body.is_earth_sized();
    let most = if image.georeference.as_ref().is_none_or(earth) { HIGHEST_M } else { f32::INFINITY };
    [(median - far).max(-most), (median + far).min(most)]
}
