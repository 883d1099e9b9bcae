//! More triangles than the index buffer holds: counted and reported, and nothing is written past the end.

use crate::harness::{device, Bench};
use terrane::frame::Look;
use terrane::verify::{random_views, TOLERANCES};
use terrane::vulkan::{download, Commands};
use terrane_planet::draw::layout::Mode;

/// Triangles, far fewer than any view emits.
const CAPACITY: u32 = 20;
/// A word that no emitted index has.
const UNTOUCHED: u32 = u32::MAX;

#[test]
fn triangles_past_the_capacity_are_counted_and_not_written() {
    let Some(context) = device() else { return };
    let mut bench = Bench::new(&context);
    let view = random_views(&bench.scene, 3, 1, &TOLERANCES)[0];
    let cut = bench.scene.settle(&view).unwrap();
    let look = Look { mode: Mode::Levels, ..Look::daylight(view.eye.normalize()) };
    let whole = bench.headless.render(&bench.scene, &view, &cut, &look).unwrap().counters;
    assert!(whole.wanted > CAPACITY && whole.wanted <= whole.capacity, "{whole:?}");

    bench.headless.renderer.buffers.max_triangles = CAPACITY;
    let indices = &bench.headless.renderer.buffers.indices;
    let bytes = indices.bytes() / 4 * 4;
    Commands::once(&context, "mark", |commands| commands.fill_buffer(indices, 0, bytes, UNTOUCHED)).unwrap();
    let cropped = bench.headless.render(&bench.scene, &view, &cut, &look).unwrap();
    assert_eq!((cropped.counters.wanted, cropped.counters.capacity), (whole.wanted, CAPACITY));
    assert_eq!(cropped.counters.index_count, 3 * CAPACITY);
    let words: Vec<u32> = download(&context, &bench.headless.renderer.buffers.indices, (bytes / 4) as usize).unwrap();
    let (written, beyond) = words.split_at(3 * CAPACITY as usize);
    assert!(written.iter().all(|&w| w != UNTOUCHED), "the buffer was not filled");
    assert!(!beyond.is_empty() && beyond.iter().all(|&w| w == UNTOUCHED), "written past the capacity");
    let pixels = bench.headless.pixels().unwrap();
    assert_eq!(pixels.len(), 64 * 64 * 4);

    let report = bench.verifier.check(&mut bench.scene, &mut bench.headless, &view).unwrap();
    assert!(report.dropped > 0 && report.cracks > 0, "an overflow must not pass for a surface: {report:?}");
}
