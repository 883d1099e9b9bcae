//! The swapchain, on a surface that shows nothing.

use super::device_with;
use crate::vulkan::{Access, ColorTarget, Context, Swapchain};

#[test]
fn frames_go_round_and_follow_the_window() {
    let created = device_with(Context::with_headless_surface);
    let Some((context, surface)) = created else {
        return;
    };
    let mut swapchain = Swapchain::new(&context, surface, (64, 48), false).unwrap();
    let mut timed = 0;
    for number in 0..12 {
        if number == 6 {
            swapchain.resize(80, 40);
        }
        let mut frame = swapchain.acquire().unwrap().expect("an image");
        assert_eq!(frame.target.size(), if number < 6 { (64, 48) } else { (80, 40) });
        timed += usize::from(frame.timestamps.as_ref().is_some_and(|times| times.ms("clear").is_some()));
        let target = frame.target.clone();
        let commands = &mut frame.commands;
        commands.transition(&target, Access::Undefined, Access::ColorTarget).unwrap();
        commands
            .zone("clear", |commands| {
                let clear = Some([0.5; 4]);
                commands.begin_rendering(&[ColorTarget { view: &target, clear }], None)?;
                commands.end_rendering()
            })
            .unwrap();
        commands.transition(&target, Access::ColorTarget, Access::Present).unwrap();
        swapchain.present(frame).unwrap();
    }
    assert_eq!(timed, 10, "all but the first frame of each slot report times");
    swapchain.resize(0, 0);
    assert!(swapchain.acquire().unwrap().is_none(), "minimized");
    swapchain.resize(64, 48);
    drop(swapchain.acquire().unwrap().expect("an image again"));
}
