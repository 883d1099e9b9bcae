//! Options of how a picture looks: what is drawn, light, exposure, tone, and what is left out.

use super::viewing::numbers;
use anyhow::{bail, Context as _};
use clap::ValueEnum as _;
use glam::DVec3;
use jiff::Timestamp;
use terrane::frame::{sun_over, Look};
use terrane_planet::draw::layout::{Mode, Tone};
use terrane_planet::draw::view_line::{Daylight, Exposure, ViewLine};
use terrane_planet::globe::sun;
use terrane_planet::recipe::Recipe;

/// Where the sun stands over the site in view unless told otherwise: azimuth and elevation in degrees.
const DEFAULT_SUN: [f64; 2] = [135.0, 35.0];

/// What is drawn.
#[derive(clap::ValueEnum, Clone, Copy, Debug)]
enum ModeOption {
    Shaded,
    Wire,
    Levels,
    Normals,
    Albedo,
    Depth,
    Wake,
    Error,
}

impl ModeOption {
    fn mode(self) -> Mode {
        match self {
            ModeOption::Shaded => Mode::Shaded,
            ModeOption::Wire => Mode::Wire,
            ModeOption::Levels => Mode::Levels,
            ModeOption::Normals => Mode::Normals,
            ModeOption::Albedo => Mode::Albedo,
            ModeOption::Depth => Mode::Depth,
            ModeOption::Wake => Mode::Wake,
            ModeOption::Error => Mode::Error,
        }
    }

    fn of(mode: Mode) -> ModeOption {
        ModeOption::value_variants().iter().copied().find(|option| option.mode() == mode).unwrap_or(ModeOption::Shaded)
    }
}

/// The curve from light to the display.
#[derive(clap::ValueEnum, Clone, Copy, Debug)]
enum ToneOption {
    Neutral,
    Agx,
}

impl ToneOption {
    fn tone(self) -> Tone {
        match self {
            ToneOption::Neutral => Tone::Neutral,
            ToneOption::Agx => Tone::Agx,
        }
    }

    fn of(tone: Tone) -> ToneOption {
        ToneOption::value_variants().iter().copied().find(|option| option.tone() == tone).unwrap_or(ToneOption::Neutral)
    }
}

/// How the picture looks.
#[derive(clap::Args, Clone, Debug)]
pub(crate) struct LookOptions {
    /// What is drawn [default: shaded].
    #[arg(long, value_enum)]
    mode: Option<ModeOption>,
    /// Where the sun stands over the site below the camera: degrees clockwise from north, and above the horizon.
    #[arg(long, value_name = "AZIMUTH,ELEVATION", value_parser = numbers::<2>, allow_hyphen_values = true)]
    sun: Option<[f64; 2]>,
    /// The sun by date and time, such as 2026-06-21T12:00Z: as over the Earth, with the axial tilt of the recipe.
    #[arg(long, value_name = "TIME", value_parser = seconds, conflicts_with = "sun")]
    date: Option<i64>,
    /// Factor on the brightness of the picture, 1 being right for the light of sun and sky below the camera; or `auto`, by how bright
    /// the picture is too. The default is 1, and `auto` in a window.
    #[arg(long, value_name = "auto|VALUE", value_parser = exposure)]
    exposure: Option<Exposure>,
    /// The curve from light to the display: `neutral`, or the filmic `agx` [default: neutral].
    #[arg(long, value_enum)]
    tone: Option<ToneOption>,
    /// Leave the clouds out.
    #[arg(long)]
    clear_sky: bool,
    /// Leave the sea out: its floor shows.
    #[arg(long)]
    no_sea: bool,
    /// Leave the air out.
    #[arg(long)]
    no_air: bool,
    /// Let the relief cast no shadows.
    #[arg(long)]
    no_shadows: bool,
}

/// Seconds since 1970 of a time with its zone.
fn seconds(text: &str) -> anyhow::Result<i64> {
    let time: Timestamp = text.parse().with_context(|| format!("'{text}' is not a time such as 2026-06-21T12:00Z"))?;
    Ok(time.as_second())
}

fn exposure(text: &str) -> anyhow::Result<Exposure> {
    match text.parse::<f32>() {
        _ if text == "auto" => Ok(Exposure::Auto),
        Ok(factor) if (1e-6..=1e6).contains(&factor) => Ok(Exposure::Fixed(factor)),
        _ => bail!("'{text}' is neither 'auto' nor a number from 1e-6 to 1e6"),
    }
}

impl LookOptions {
    /// Whether a date says where the sun is.
    pub(crate) fn has_date(&self) -> bool {
        self.date.is_some()
    }

    /// Takes from a view what was not given.
    pub(crate) fn take(&mut self, line: &ViewLine) {
        match line.daylight {
            Some(Daylight::Over(sun)) if self.date.is_none() => self.sun = self.sun.or(Some(sun)),
            Some(Daylight::Date(date)) if self.sun.is_none() => self.date = self.date.or(Some(date)),
            _ => {}
        }
        self.exposure = self.exposure.or(line.exposure);
        self.mode = self.mode.or(line.mode.map(ModeOption::of));
        self.tone = self.tone.or(line.tone.map(ToneOption::of));
        self.clear_sky |= line.clear_sky;
        self.no_sea |= line.no_sea;
        self.no_air |= line.no_air;
        self.no_shadows |= line.no_shadows;
    }

    /// Puts into a view how the picture looks; what is as usual only where it may not be usual elsewhere.
    pub(crate) fn note(&self, line: &mut ViewLine, usual: Exposure) {
        let sun = Daylight::Over(self.sun.unwrap_or(DEFAULT_SUN));
        line.daylight = Some(self.date.map_or(sun, Daylight::Date));
        line.exposure = Some(self.exposure.unwrap_or(usual));
        line.mode = Some(self.mode()).filter(|mode| *mode != Mode::Shaded);
        line.tone = Some(self.tone()).filter(|tone| *tone != Tone::Neutral);
        line.clear_sky = self.clear_sky;
        line.no_sea = self.no_sea;
        line.no_air = self.no_air;
        line.no_shadows = self.no_shadows;
    }

    fn mode(&self) -> Mode {
        self.mode.map_or(Mode::Shaded, ModeOption::mode)
    }

    fn tone(&self) -> Tone {
        self.tone.map_or(Tone::Neutral, ToneOption::tone)
    }

    /// The look of a picture over a site of a planet, exposed in the usual way unless told otherwise.
    pub(crate) fn look(&self, recipe: &Recipe, site: DVec3, usual: Exposure) -> Look {
        let [azimuth, elevation] = self.sun.unwrap_or(DEFAULT_SUN);
        let by_date = |date| sun::direction(date as f64, recipe.axial_tilt);
        let sun = self.date.map_or_else(|| sun_over(site, azimuth, elevation), by_date);
        let (factor, metering) = match self.exposure.unwrap_or(usual) {
            Exposure::Auto => (1.0, Some(1.0)),
            Exposure::Fixed(factor) => (factor, None),
        };
        Look {
            mode: self.mode(),
            sun,
            exposure: factor,
            tone: self.tone(),
            metering,
            clouds: !self.clear_sky,
            sea: !self.no_sea,
            air: !self.no_air,
            shadows: !self.no_shadows,
        }
    }
}
