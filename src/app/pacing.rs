//! How many pixels a frame of the window draws, and when the next one is due.
//!
//! In: what earlier frames cost, and whether anything moves. Out: a density (pixels drawn along a side for each of the window's), and the
//! time of the next frame. While the viewer moves, density follows a budget of milliseconds; once they stand still it is 1, and when
//! nothing changes any more nothing is drawn.

use std::time::{Duration, Instant};

/// Densities that frames are drawn with: few, so that going from one to another finds its images made already.
pub const DENSITIES: [f64; 5] = [1.0, 0.75, 0.5, 0.375, 0.25];

/// How long after the last motion the viewer counts as standing.
const STANDING: Duration = Duration::from_millis(120);
/// How long exposure adapts after the last change: four times as long as it takes for most of the way.
const ADAPTING: Duration = Duration::from_millis(2400);
/// How often to look whether patches have arrived.
const LOOK_FOR_ARRIVALS: Duration = Duration::from_millis(15);
/// Share of the time that pictures of patches as they arrive may take where pictures and patches are made by the same cores.
const SHOWING: f64 = 0.2;
/// Share of the budget below which more pixels are tried, so that density does not go to and fro.
const ROOM: f64 = 0.75;
/// Weight of the latest frame in what frames cost.
const RESPONSE: f64 = 0.3;

/// How many pixels a window draws.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scale {
    /// As many as keep moving frames within so many milliseconds.
    Within(f64),
    /// Always so many along a side for each of the window's, from 0.25 to 1.
    Fixed(f64),
}

/// What a finished frame cost, in milliseconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cost {
    /// What it was drawn with.
    pub(super) density: f64,
    /// Of its stages that work on pixels.
    pub(super) pixels_ms: f64,
    /// Of everything else, on the GPU and the CPU.
    pub(super) fixed_ms: f64,
}

/// What may ask for another frame.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Motives {
    /// The viewer moves by themselves: keys are held, a zoom is under way, a path plays, or the sea has waves.
    pub(super) moving: bool,
    /// Patches have arrived that no picture shows yet.
    pub(super) arrived: bool,
    /// Patches are on their way.
    pub(super) pending: bool,
    /// Exposure follows the picture.
    pub(super) metered: bool,
    /// When something said is to vanish, or the interface moves by itself.
    pub(super) until: Option<Instant>,
}

/// When the next frame is due.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Due {
    /// At once.
    Now,
    /// Look again then.
    At(Instant),
    /// Not before something happens to the window.
    Never,
}

/// The pace of a window.
pub(super) struct Pacing {
    scale: Scale,
    /// Least time from frame to frame.
    least: Duration,
    /// Whether pictures are made by the cores that build patches, too.
    shares_cores: bool,
    /// Smoothed cost of a frame of density 1 that works on pixels, and of the rest.
    cost: Option<(f64, f64)>,
    /// Chosen last for a moving frame.
    chosen: f64,
    moved: Option<Instant>,
    changed: Instant,
    /// Whether something happened that no picture shows yet, or the interface does not.
    dirty: bool,
    interface_dirty: bool,
    /// When the latest frame began, and the latest that drew a picture.
    drawn: Option<Instant>,
    pictured: Option<Instant>,
}

impl Pacing {
    /// Of a window whose frames come at most `most_fps` times a second.
    pub(super) fn new(scale: Scale, most_fps: f64, shares_cores: bool) -> Pacing {
        // The first moving frame has to guess.
        let chosen = if let Scale::Within(ms) = scale {
            if ms < f64::INFINITY {
                0.5
            } else {
                1.0
            }
        } else {
            1.0
        };
        let least = Duration::from_secs_f64(1.0 / most_fps);
        let changed = Instant::now();
        Pacing {
            scale,
            least,
            shares_cores,
            cost: None,
            chosen,
            moved: None,
            changed,
            dirty: true,
            interface_dirty: false,
            drawn: None,
            pictured: None,
        }
    }

    /// Draws so many pixels from now on.
    pub(super) fn set_scale(&mut self, scale: Scale) {
        self.scale = scale;
    }

    /// Something happened that only the interface shows.
    pub(super) fn touch_interface(&mut self) {
        self.interface_dirty = true;
    }

    /// Something happened to the window, or to what it shows.
    pub(super) fn touch(&mut self, now: Instant) {
        self.dirty = true;
        self.changed = now;
    }

    /// The same, where that need not be shown more often than so.
    pub(super) fn touch_interface_within(&mut self, now: Instant, least: Duration) {
        self.interface_dirty |= self.drawn.is_none_or(|drawn| now.duration_since(drawn) >= least);
    }

    /// The viewer moved in the frame that begins `now`.
    pub(super) fn moved(&mut self, now: Instant) {
        self.moved = Some(now);
        self.changed = now;
    }

    /// Learns from a frame that is done.
    pub(super) fn learn(&mut self, cost: Cost) {
        let whole = cost.pixels_ms / (cost.density * cost.density);
        let follow = |known: f64, found: f64| known + (found - known) * RESPONSE;
        self.cost = Some(match self.cost {
            Some((pixels, fixed)) => (follow(pixels, whole), follow(fixed, cost.fixed_ms)),
            None => (whole, cost.fixed_ms),
        });
    }

    /// The density of the frame that begins `now`.
    pub(super) fn density(&mut self, now: Instant) -> f64 {
        match self.scale {
            Scale::Fixed(density) => density,
            Scale::Within(_) if !self.is_moving(now) => 1.0,
            Scale::Within(budget) => {
                if let Some((pixels, fixed)) = self.cost {
                    let fits = |density: f64| {
                        let most = if density > self.chosen { ROOM * budget } else { budget };
                        fixed + pixels * density * density <= most
                    };
                    let least = DENSITIES[DENSITIES.len() - 1];
                    self.chosen = DENSITIES.into_iter().find(|density| fits(*density)).unwrap_or(least);
                }
                self.chosen
            }
        }
    }

    fn is_moving(&self, now: Instant) -> bool {
        self.moved.is_some_and(|at| now.duration_since(at) < STANDING)
    }

    /// A frame begins, with a picture of its own or over the one before.
    pub(super) fn begin(&mut self, now: Instant, with_picture: bool) {
        self.interface_dirty = false;
        self.drawn = Some(now);
        if with_picture {
            self.dirty = false;
            self.pictured = Some(now);
        }
    }

    /// Whether a frame that begins `now` would show another picture than the one before.
    pub(super) fn wants_picture(&self, now: Instant, motives: &Motives) -> bool {
        let adapts = motives.metered && now.duration_since(self.changed) < ADAPTING;
        // A picture drawn while moving may have had too few pixels.
        let sharpens = self.moved.is_some_and(|at| self.pictured.is_some_and(|drawn| drawn < at + STANDING));
        let arrived = motives.arrived && self.shows_arrivals_at(motives).is_none_or(|at| at <= now);
        self.dirty || motives.moving || arrived || adapts || (sharpens && !self.is_moving(now))
    }

    /// When patches that have arrived are to be shown: at once if none, or if they were the last.
    fn shows_arrivals_at(&self, motives: &Motives) -> Option<Instant> {
        let (pixels, fixed) = self.cost.filter(|_| self.shares_cores && motives.pending)?;
        Some(self.pictured? + Duration::from_secs_f64((pixels + fixed) * 1e-3 / SHOWING))
    }

    /// When the next frame is due.
    pub(super) fn due(&self, now: Instant, motives: &Motives) -> Due {
        let asked = motives.until.is_some_and(|at| at <= now);
        if self.wants_picture(now, motives) || self.interface_dirty || asked {
            return match self.drawn.map(|drawn| drawn + self.least).filter(|at| *at > now) {
                Some(at) => Due::At(at),
                None => Due::Now,
            };
        }
        let standing_at = self.moved.map(|at| at + STANDING).filter(|at| *at > now);
        let look = (motives.pending || motives.arrived).then(|| now + LOOK_FOR_ARRIVALS);
        match [standing_at, look, motives.until].into_iter().flatten().min() {
            Some(at) => Due::At(at),
            None => Due::Never,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NONE: Motives = Motives { moving: false, arrived: false, pending: false, metered: false, until: None };

    /// A renderer whose frames take so long at density 1, and always.
    fn flown(budget: f64, pixels: f64, fixed: f64) -> (Pacing, Instant) {
        let (mut pacing, mut now) = (Pacing::new(Scale::Within(budget), 1000.0, false), Instant::now());
        for _ in 0..40 {
            now += Duration::from_millis(50);
            pacing.moved(now);
            let density = pacing.density(now);
            pacing.begin(now, true);
            pacing.learn(Cost { density, pixels_ms: pixels * density * density, fixed_ms: fixed });
        }
        (pacing, now)
    }

    #[test]
    fn moving_frames_keep_the_budget_with_as_many_pixels_as_it_bears() {
        for (pixels, fixed, expected) in [(20.0, 5.0, 1.0), (230.0, 26.0, 0.5), (800.0, 30.0, 0.25), (5000.0, 300.0, 0.25)] {
            let (mut pacing, now) = flown(90.0, pixels, fixed);
            assert_eq!(pacing.density(now), expected, "{pixels} {fixed}");
        }
        let (mut pacing, now) = flown(f64::INFINITY, 5000.0, 300.0);
        assert_eq!(pacing.density(now), 1.0);
    }

    #[test]
    fn density_does_not_go_to_and_fro() {
        // 0.5 takes 81 ms, 0.75 would take just less than the budget.
        let (mut pacing, now) = flown(95.0, 150.0, 10.0);
        assert_eq!(pacing.density(now), 0.5);
        pacing.chosen = 0.75;
        assert_eq!(pacing.density(now), 0.75);
    }

    #[test]
    fn who_stands_sees_all_pixels_and_then_nothing_is_drawn() {
        let (mut pacing, now) = flown(90.0, 230.0, 26.0);
        let Due::At(standing) = pacing.due(now + Duration::from_millis(2), &NONE) else { panic!("it rests at half its pixels") };
        assert!(standing - now <= Duration::from_millis(500));
        assert_eq!(pacing.due(standing, &NONE), Due::Now);
        assert_eq!(pacing.density(standing), 1.0);
        pacing.begin(standing, true);
        assert_eq!(pacing.due(standing + Duration::from_secs(1), &NONE), Due::Never);
        assert_eq!(pacing.due(standing + Duration::from_secs(1), &Motives { metered: true, ..NONE }), Due::Now);
        assert_eq!(pacing.due(standing + Duration::from_secs(3), &Motives { metered: true, ..NONE }), Due::Never);
    }

    #[test]
    fn whatever_changes_brings_a_frame_but_none_too_early() {
        let (mut pacing, now) = (Pacing::new(Scale::Fixed(1.0), 50.0, false), Instant::now());
        assert_eq!(pacing.due(now, &NONE), Due::Now);
        pacing.begin(now, true);
        let soon = now + Duration::from_millis(1);
        assert_eq!(pacing.due(soon, &NONE), Due::Never);
        assert_eq!(pacing.due(soon, &Motives { moving: true, ..NONE }), Due::At(now + Duration::from_millis(20)));
        assert_eq!(pacing.due(soon, &Motives { pending: true, ..NONE }), Due::At(soon + LOOK_FOR_ARRIVALS));
        let later = now + Duration::from_millis(40);
        assert_eq!(pacing.due(later, &Motives { arrived: true, ..NONE }), Due::Now);
        assert_eq!(pacing.due(later, &Motives { until: Some(now), ..NONE }), Due::Now);
        pacing.touch(later);
        assert_eq!(pacing.due(later, &NONE), Due::Now);
    }

    #[test]
    fn what_only_the_interface_shows_brings_a_frame_over_the_same_picture() {
        let (mut pacing, now) = (Pacing::new(Scale::Fixed(1.0), 50.0, false), Instant::now());
        assert!(pacing.wants_picture(now, &NONE));
        pacing.begin(now, true);
        let later = now + Duration::from_millis(40);
        pacing.touch_interface();
        assert_eq!((pacing.due(later, &NONE), pacing.wants_picture(later, &NONE)), (Due::Now, false));
        pacing.begin(later, false);
        assert_eq!(pacing.due(later + Duration::from_millis(40), &NONE), Due::Never);
        pacing.touch(later);
        assert!(pacing.wants_picture(later, &NONE));
    }

    #[test]
    fn where_cores_are_shared_arrivals_are_shown_now_and_then_and_the_last_at_once() {
        let (mut pacing, now) = (Pacing::new(Scale::Fixed(1.0), 50.0, true), Instant::now());
        pacing.begin(now, true);
        pacing.learn(Cost { density: 1.0, pixels_ms: 180.0, fixed_ms: 20.0 });
        let after = |ms: u64| now + Duration::from_millis(ms);
        let some = Motives { arrived: true, pending: true, ..NONE };
        assert_eq!(pacing.due(after(300), &some), Due::At(after(300) + LOOK_FOR_ARRIVALS));
        assert_eq!([900, 1100].map(|ms| pacing.wants_picture(after(ms), &some)), [false, true]);
        assert!(pacing.wants_picture(after(300), &Motives { pending: false, ..some }));
        assert!(pacing.wants_picture(after(300), &Motives { moving: true, ..some }));
    }
}
