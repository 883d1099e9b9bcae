//! Layers of the terrain, ready to evaluate: what every kind does, and the one list of kinds ([`layer_kinds`]) turned into [`Step`].
//! In: a recipe's layer. Out: a step that adds its metres to a chunk of points.

use super::points::{Lane, Points, WideLane, LANES};
use crate::recipe::{layer_kinds, Layer, Recipe, RecipeError};

/// What layers leave for those after them.
pub(super) struct Past {
    /// Base elevation in metres.
    pub(super) base: Lane,
    /// Local relief of heightmaps in metres: the standard deviation of their samples around.
    pub(super) relief: Lane,
    /// How much of the ground is younger than most craters, 0 to 1.
    pub(super) renewed: Lane,
    /// Metres of all rifts so far: where two meet the deeper one counts.
    rifts: Lane,
}

impl Past {
    /// Nothing yet but a base elevation.
    #[inline(always)]
    pub(super) fn over(base: Lane) -> Self {
        Self { base, relief: [0.0; LANES], renewed: [0.0; LANES], rifts: [0.0; LANES] }
    }

    /// What one more rift adds.
    #[inline(always)]
    pub(super) fn deepen(&mut self, mut own: Lane) -> Lane {
        for i in 0..LANES {
            let deeper = own[i].min(self.rifts[i]);
            (own[i], self.rifts[i]) = (deeper - self.rifts[i], deeper);
        }
        own
    }
}

/// What every kind of layer does. Layers skip what their masks hide from the whole chunk; that adds 0 elsewhere, so the bits do not
/// depend on the chunk.
pub(super) trait Evaluate: Sized {
    /// Its parameters.
    type Recipe;

    /// Prepares a layer of a planet.
    fn new(seed: u64, recipe: &Self::Recipe, planet: &Recipe) -> Result<Self, RecipeError>;

    /// Whether the layer belongs to the base elevation, which decides where others fade in.
    fn is_base(&self) -> bool {
        false
    }

    /// Metres of the layer's own, or nothing where it is hidden from the whole chunk.
    fn metres(&self, p: &Points, past: &mut Past) -> Option<Lane>;

    /// Adds the layer to the base elevation, if it belongs to it, and to `height` where one is given.
    #[inline(always)]
    fn compose(&self, p: &Points, past: &mut Past, height: Option<&mut WideLane>) {
        if height.is_none() && !self.is_base() {
            return;
        }
        let Some(own) = self.metres(p, past) else { return };
        if self.is_base() {
            for i in 0..LANES {
                past.base[i] += own[i];
            }
        }
        if let Some(height) = height {
            for i in 0..LANES {
                height[i] += f64::from(own[i]);
            }
        }
    }

    /// How firmly the layer keeps the sea out of each point, 0 to 1, with the border at a half.
    #[inline(always)]
    fn dry(&self, _: &Points) -> Option<Lane> {
        None
    }

    /// A height in metres that no ground lies below out of which the layer keeps the sea, before other layers dig there; nothing where
    /// it keeps the sea out of none.
    fn lowest_dry(&self) -> Option<f64> {
        None
    }

    /// Least and most that the layer adds to ground no lower than `low`.
    fn range(&self, low: f64) -> (f64, f64);

    /// Bounds of the ground with the layer, from those without it.
    fn bound(&self, (low, high): (f64, f64)) -> (f64, f64) {
        let (least, most) = self.range(low);
        (low + least, high + most)
    }
}

macro_rules! steps {
    ($($(#[$meta:meta])* $kind:ident = $name:literal in $file:ident;)*) => {
        /// One layer, ready to evaluate.
        pub(super) enum Step {
            $($kind(Box<super::$file::$kind>),)*
        }

        impl Step {
            /// Prepares a layer of a planet.
            pub(super) fn new(seed: u64, layer: &Layer, planet: &Recipe) -> Result<Self, RecipeError> {
                Ok(match layer {
                    $(Layer::$kind(own) => Self::$kind(Box::new(super::$file::$kind::new(seed, own, planet)?)),)*
                })
            }

            /// See [`Evaluate::compose`].
            #[inline(always)]
            pub(super) fn compose(&self, p: &Points, past: &mut Past, height: Option<&mut WideLane>) {
                match self {
                    $(Self::$kind(layer) => layer.compose(p, past, height),)*
                }
            }

            /// See [`Evaluate::dry`].
            #[inline(always)]
            pub(super) fn dry(&self, p: &Points) -> Option<Lane> {
                match self {
                    $(Self::$kind(layer) => layer.dry(p),)*
                }
            }

            /// See [`Evaluate::lowest_dry`].
            pub(super) fn lowest_dry(&self) -> Option<f64> {
                match self {
                    $(Self::$kind(layer) => layer.lowest_dry(),)*
                }
            }

            /// Metres, not above 0, by which the layer may lower ground that is not of its own making.
            pub(super) fn digs(&self) -> f64 {
                match self {
                    $(Self::$kind(layer) if !layer.is_base() => layer.range(0.0).0.min(0.0),)*
                    _ => 0.0,
                }
            }

            /// See [`Evaluate::bound`].
            pub(super) fn bound(&self, range: (f64, f64)) -> (f64, f64) {
                match self {
                    $(Self::$kind(layer) => layer.bound(range),)*
                }
            }
        }
    };
}

layer_kinds!(steps);

/// A planet of some radius, for tests of layers.
#[cfg(test)]
pub(super) fn planet(radius: f64) -> Recipe {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("recipes/tiny.toml");
    Recipe { radius, ..Recipe::load(&path).unwrap() }
}
