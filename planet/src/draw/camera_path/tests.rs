//! What must hold of every path.

use super::*;
use crate::draw::view_line::Stand;
use glam::DVec3;
use proptest::prelude::*;

fn key(time_s: f64, [latitude, longitude]: [f64; 2], altitude_m: f64, heading: f64) -> Keyframe {
    Keyframe { time_s, latitude, longitude, stand: Stand::Altitude(altitude_m), heading, pitch: -30.0, fov: 50.0 }
}

fn altitude(waypoint: &Waypoint) -> f64 {
    let (Stand::Altitude(metres) | Stand::Height(metres)) = waypoint.stand;
    metres
}

/// Position over the ground, view direction and top of the picture.
fn facing(waypoint: &Waypoint) -> [DVec3; 3] {
    let (forward, top) = waypoint.facing();
    [waypoint.up, forward, top]
}

/// How fast these change at a time, seen from before (-1) or after (1), to second order.
fn speeds(path: &CameraPath, time_s: f64, side: f64) -> [DVec3; 3] {
    let step = side * 1e-5;
    let [here, near, far] = [0.0, step, 2.0 * step].map(|later| facing(&path.at(time_s + later)));
    std::array::from_fn(|k| (near[k] * 4.0 - here[k] * 3.0 - far[k]) / (2.0 * step))
}

/// Keyframes some seconds apart, anywhere, poles and both spellings of longitudes among them.
fn keyframes() -> impl Strategy<Value = Vec<Keyframe>> {
    let latitude = prop_oneof![4 => -89.0..89.0f64, 1 => Just(90.0), 1 => Just(-90.0)];
    let one = (0.5..20.0f64, latitude, -180i32..180, 0.0..14.0f64, -180.0..180.0f64, -90.0..0.0f64);
    prop::collection::vec(one, 2..7).prop_map(|all| {
        let mut time_s = 0.0;
        let mut next = |(step, latitude, longitude, rung, heading, pitch): (f64, f64, i32, f64, f64, f64)| {
            time_s += step;
            Keyframe { pitch, ..key(time_s, [latitude, f64::from(longitude)], rung.exp(), heading) }
        };
        all.into_iter().map(&mut next).collect()
    })
}

proptest! {
    #[test]
    fn paths_pass_through_their_keyframes(keys in keyframes()) {
        let Ok(path) = CameraPath::new(&keys) else { return Ok(()) };
        for key in &keys {
            let (found, wanted) = (path.at(key.time_s), Waypoint::of(key));
            prop_assert!(found.up.distance(wanted.up) < 1e-9 && found.ahead.distance(wanted.ahead) < 1e-6, "{found:?} {wanted:?}");
            prop_assert!((altitude(&found) / altitude(&wanted) - 1.0).abs() < 1e-9 && (found.pitch - key.pitch).abs() < 1e-9);
        }
    }

    #[test]
    fn altitudes_and_pitches_stay_between_their_keyframes(keys in keyframes(), share in 0.0..1.0f64) {
        let Ok(path) = CameraPath::new(&keys) else { return Ok(()) };
        for pair in keys.windows(2) {
            let found = path.at(pair[0].time_s + share * (pair[1].time_s - pair[0].time_s));
            let [a, b] = [pair[0], pair[1]].map(|key| altitude(&Waypoint::of(&key)));
            prop_assert!((a.min(b) * (1.0 - 1e-9)..=a.max(b) * (1.0 + 1e-9)).contains(&altitude(&found)));
            prop_assert!((pair[0].pitch.min(pair[1].pitch)..=pair[0].pitch.max(pair[1].pitch)).contains(&found.pitch));
        }
    }

    #[test]
    fn position_and_view_have_no_kink(keys in keyframes()) {
        let Ok(path) = CameraPath::new(&keys) else { return Ok(()) };
        for key in &keys[1..keys.len() - 1] {
            let [before, after] = [speeds(&path, key.time_s, -1.0), speeds(&path, key.time_s, 1.0)];
            for (before, after) in before.iter().zip(after) {
                prop_assert!(before.distance(after) < 1e-3, "{before} and {after} at {}", key.time_s);
            }
        }
    }

    #[test]
    fn whole_turns_of_longitude_and_heading_change_nothing(keys in keyframes(), share in 0.0..1.0f64) {
        // Whole degrees: others lose bits to the turn.
        let keys: Vec<Keyframe> = keys.iter().map(|key| Keyframe { heading: key.heading.round(), ..*key }).collect();
        let Ok(path) = CameraPath::new(&keys) else { return Ok(()) };
        let other = |degrees: f64| if degrees <= 0.0 { degrees + 360.0 } else { degrees - 360.0 };
        let turned = |key: &Keyframe| Keyframe { longitude: other(key.longitude), heading: other(key.heading), ..*key };
        let again = CameraPath::new(&keys.iter().map(turned).collect::<Vec<_>>()).unwrap();
        let time_s = path.span().0 + share * (path.span().1 - path.span().0);
        let (a, b) = (path.at(time_s), again.at(time_s));
        prop_assert!(a.up.distance(b.up) < 1e-12 && a.ahead.distance(b.ahead) < 1e-9, "{a:?} {b:?}");
    }

    #[test]
    fn a_constant_pace_begins_and_ends_where_keyframes_do(keys in keyframes(), share in 0.0..1.0f64) {
        let Ok(path) = CameraPath::at_constant_pace(&keys, 6e6) else { return Ok(()) };
        let (first, last) = path.span();
        prop_assert!(path.at(first).up.distance(Waypoint::of(&keys[0]).up) < 1e-9);
        prop_assert!(path.at(last).up.distance(Waypoint::of(&keys[keys.len() - 1]).up) < 1e-9);
        prop_assert!(facing(&path.at(first + share * (last - first))).iter().all(|vector| vector.is_finite()));
    }
}

#[test]
fn a_flight_over_the_pole_goes_straight_on() {
    let keys = [key(0.0, [80.0, 30.0], 1e5, 0.0), key(10.0, [89.0, 30.0], 1e5, 0.0), key(20.0, [82.0, -150.0], 1e5, 180.0)];
    let path = CameraPath::new(&keys).unwrap();
    let across = Waypoint::of(&key(0.0, [0.0, 120.0], 1e5, 0.0)).up;
    let mut before = path.at(0.0);
    let mut nearest: f64 = 1.0;
    for k in 1..=2000 {
        let now = path.at(f64::from(k) / 100.0);
        nearest = nearest.min(leg::angle(now.up, DVec3::Z));
        // The camera stays in the plane of the meridian and turns no more than the ground curves below it.
        assert!(now.up.dot(across).abs() < 1e-12 && now.ahead.dot(across).abs() < 1e-9, "{now:?}");
        assert!(leg::angle(now.ahead, before.ahead) < leg::angle(now.up, before.up) + 1e-9);
        before = now;
    }
    assert!(nearest < 1e-3);
}

#[test]
fn a_carried_direction_keeps_its_elevation_over_poles_and_round_the_planet() {
    let keys = [
        key(0.0, [-60.0, 0.0], 1e5, 0.0),
        key(9.0, [60.0, 10.0], 1e5, 0.0),
        key(20.0, [70.0, 180.0], 1e5, 0.0),
        key(30.0, [-10.0, 170.0], 1e5, 0.0),
    ];
    let path = CameraPath::new(&keys).unwrap();
    let end = path.at(30.0).up;
    let sun = (end + leg::level(DVec3::Y, end)).normalize();
    let carried = path.carry(sun);
    assert!(carried.at(30.0).distance(sun) < 1e-12 && path.reach() > 1.5);
    for k in 0..=3000 {
        let time_s = f64::from(k) / 100.0;
        assert!((carried.at(time_s).dot(path.at(time_s).up) - sun.dot(end)).abs() < 1e-3, "at {time_s} s");
    }
}

#[test]
fn headings_by_compass_would_spin_at_the_pole() {
    // The control of the test above: what the path has in place of compass headings is what keeps it from turning.
    let path = CameraPath::new(&[key(0.0, [80.0, 30.0], 1e5, 0.0), key(20.0, [82.0, -150.0], 1e5, 180.0)]).unwrap();
    let headings: Vec<f64> = (0..=2000).map(|k| path.at(f64::from(k) / 100.0).keyframe().heading).collect();
    assert!(headings.windows(2).any(|pair| (pair[1] - pair[0]).abs() > 90.0));
}

#[test]
fn angles_go_the_short_way_and_altitudes_geometrically() {
    let path = CameraPath::new(&[key(0.0, [0.0, 170.0], 1e6, 10.0), key(2.0, [0.0, -170.0], 1e2, 350.0)]).unwrap();
    let middle = path.at(1.0).keyframe();
    assert!((middle.longitude.abs() - 180.0).abs() < 1e-9 && middle.heading.abs() < 1e-9, "{middle:?}");
    assert!((altitude(&path.at(1.0)) - 1e4).abs() < 1e-6);
}

#[test]
fn heights_lead_level_over_anything() {
    let level = |time_s, longitude| Keyframe { stand: Stand::Height(250.0), ..key(time_s, [10.0, longitude], 1.0, 90.0) };
    let path = CameraPath::new(&[level(0.0, 1.0), level(4.0, 2.0), level(9.0, 3.0)]).unwrap();
    for k in 0..=90 {
        let Stand::Height(height) = path.at(f64::from(k) / 10.0).stand else { panic!("an altitude") };
        assert!((height - 250.0).abs() < 1e-9, "{height}");
    }
    let sunk = Keyframe { stand: Stand::Height(-400.0), ..level(9.0, 3.0) };
    let path = CameraPath::new(&[level(0.0, 1.0), sunk]).unwrap();
    assert!((altitude(&path.at(4.5)) + 75.0).abs() < 10.0, "evenly, near the datum");
}

#[test]
fn a_constant_pace_halves_altitudes_in_equal_times() {
    let keys = [key(0.0, [10.0, 20.0], 1.6e7, 40.0), key(1.0, [10.0, 20.0], 1e6, 40.0), key(60.0, [10.0, 20.0], 1e2, 40.0)];
    let path = CameraPath::at_constant_pace(&keys, 6e6).unwrap();
    assert_eq!(path.span(), (0.0, 60.0));
    let at = |time_s: f64| altitude(&path.at(time_s)).ln();
    let falls: Vec<f64> = (6..54).map(|k| at(f64::from(k)) - at(f64::from(k + 1))).collect();
    assert!(falls.iter().all(|fall| (fall / falls[0] - 1.0).abs() < 1e-3), "{falls:?}");
    // Eased at the ends, and timed paths take the times at their word.
    assert!(at(0.0) - at(1.0) < 0.2 * falls[0] && at(59.0) - at(60.0) < 0.2 * falls[0]);
    let timed = CameraPath::new(&keys).unwrap();
    assert!((altitude(&timed.at(1.0)) - 1e6).abs() < 1e-3 && altitude(&path.at(1.0)) > 1e7);
}

#[test]
fn a_constant_pace_has_no_kink() {
    let keys = [
        key(0.0, [60.0, 20.0], 1e5, 0.0),
        key(3.0, [85.0, 60.0], 4e5, 90.0),
        key(20.0, [80.0, 150.0], 6e5, 150.0),
        key(25.0, [40.0, 160.0], 1e5, 170.0),
    ];
    let path = CameraPath::at_constant_pace(&keys, 6e6).unwrap();
    let mut before: Option<[DVec3; 3]> = None;
    for k in 1..25_000 {
        let now = speeds(&path, f64::from(k) / 1000.0, 1.0);
        if let Some(before) = before.replace(now) {
            let jump = before.iter().zip(now).map(|(before, now)| before.distance(now)).fold(0.0, f64::max);
            assert!(jump < 0.003, "{jump} at {} s", f64::from(k) / 1000.0);
        }
    }
}

#[test]
fn a_constant_pace_goes_through_all_places_in_their_order() {
    let keys = [
        key(0.0, [10.0, 20.0], 1e4, 0.0),
        key(1.0, [11.0, 21.0], 2e4, 90.0),
        key(2.0, [11.0, 21.0], 2e4, 90.0),
        key(9.0, [12.0, 20.0], 500.0, 0.0),
    ];
    let path = CameraPath::at_constant_pace(&keys, 6e6).unwrap();
    let wanted = Waypoint::of(&keys[1]).up;
    let nearest = (0..=9000).map(|k| leg::angle(path.at(f64::from(k) / 1000.0).up, wanted)).fold(1.0, f64::min);
    assert!(nearest < 1e-4, "{nearest}");
    let still = [keys[1], keys[2]];
    assert_eq!(CameraPath::at_constant_pace(&still, 6e6).unwrap().at(1.5).up, wanted);
}

#[test]
fn bad_keyframes_are_named() {
    let fails = |keys: &[Keyframe]| CameraPath::new(keys).unwrap_err();
    let good = key(0.0, [0.0, 0.0], 1.0, 0.0);
    assert_eq!(fails(&[good]), PathError::TooFew { found: 1 });
    assert_eq!(fails(&[key(1.0, [0.0; 2], 1.0, 0.0), key(1.0, [0.0; 2], 1.0, 0.0)]), PathError::Order { number: 1, time_s: 1.0 });
    let value = fails(&[good, key(1.0, [0.0; 2], 0.0, 0.0)]);
    assert!(value.to_string().starts_with("keyframe 1: altitude_m is 0,"), "{value}");
    fails(&[key(0.0, [0.0, f64::NAN], 1.0, 0.0), key(1.0, [0.0; 2], 1.0, 0.0)]);
    let level = Keyframe { stand: Stand::Height(1.0), ..key(1.0, [0.0; 2], 1.0, 0.0) };
    let mixed = fails(&[good, level]);
    assert!(mixed.to_string().starts_with("keyframe 1 has height_m, expected altitude_m"), "{mixed}");
    let low = fails(&[Keyframe { stand: Stand::Height(-2e8), ..good }, level]);
    assert!(low.to_string().starts_with("keyframe 0: height_m is -200000000,"), "{low}");
    let opposite = fails(&[good, key(1.0, [0.0, 180.0], 1.0, 0.0)]);
    assert!(opposite.to_string().contains("180.0 degrees from the one before"), "{opposite}");
}

#[test]
fn routes_come_back_from_their_json() {
    let keys = vec![key(0.0, [1.5, 20.0], 1e4, 0.1), key(7.25, [11.0, 21.0], 2e4, 90.0)];
    for pace in [Pace::Timed, Pace::Constant] {
        let route = Route { pace, keyframes: keys.clone() };
        assert_eq!(Route::from_json(&route.to_json()).unwrap(), route, "{}", route.to_json());
    }
    let list = serde_json::to_string(&keys).unwrap();
    assert_eq!(Route::from_json(&list).unwrap(), Route::timed(keys.clone()));
    assert_eq!(Route::from_json(&format!("{{\"keyframes\":{list}}}")).unwrap(), Route::timed(keys));
    assert!(Route::from_json(&format!("{{\"keyframes\":{list},\"pace\":\"slow\"}}")).unwrap_err().to_string().contains("slow"));
}
