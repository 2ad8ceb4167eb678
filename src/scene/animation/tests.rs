//! Tracks against closed forms, and their refusals.

use super::*;
use crate::scene::{parse, preset, to_text};
use crate::shader;

/// A scene with an animation, at a time.
fn moving(animation: &str, time: f64) -> Result<Scene, SceneError> {
    let mut scene = parse(&format!("preset = \"fire\"\n[animation]\n{animation}\n"), "x.toml")?;
    scene.camera.time = time;
    scene.check(&shader::shipped())?;
    scene.moment().map(Cow::into_owned)
}

fn zoom(animation: &str, time: f64) -> f32 {
    moving(animation, time).unwrap().camera.zoom
}

#[test]
fn a_number_goes_from_key_to_key_in_the_way_that_its_key_says() {
    let keys =
        |ease: &str| format!("camera.zoom = [{{ time = 1, value = 2, ease = \"{ease}\" }}, {{ time = 3, value = 4 }}]");
    for (ease, at_two_and_a_half) in [("linear", 3.5), ("smooth", 2.0 + 2.0 * 0.84375), ("hold", 2.0)] {
        assert_eq!([0.0, 1.0, 3.0, 9.0].map(|time| zoom(&keys(ease), time)), [2.0, 2.0, 4.0, 4.0], "{ease}");
        assert_eq!(zoom(&keys(ease), 2.5), at_two_and_a_half, "{ease}: 3 u^2 - 2 u^3 of u = 3/4");
    }
}

#[test]
fn smooth_interpolation_has_continuous_speed_within_its_keys() {
    let keys = [(0.0, 1.0), (1.0, 1.5), (2.0, 6.0), (4.0, 6.0), (5.0, 2.0)];
    let list = keys.map(|(time, value)| format!("{{ time = {time}, value = {value}, ease = \"smooth\" }}")).join(",");
    for period in ["", "loop = 6\n"] {
        let track = format!("{period}camera.zoom = [{list}]");
        let at = |time: f64| f64::from(zoom(&track, time));
        for ((from, a), (to, b)) in keys.iter().zip(&keys[1..]) {
            let (low, high) = (f64::min(*a, *b) - 1e-6, f64::max(*a, *b) + 1e-6);
            assert!((1..10).all(|k| (low..=high).contains(&at(from + (to - from) * f64::from(k) / 10.0))));
            let speeds = [at(*to) - at(to - 1e-3), at(to + 1e-3) - at(*to)].map(|step| step / 1e-3);
            assert!((speeds[0] - speeds[1]).abs() < 0.05, "{to} s: {speeds:?}");
        }
    }
}

#[test]
fn a_loop_goes_on_from_its_last_key_to_its_first() {
    let track = "loop = 4\ncamera.zoom = [{ time = 1, value = 1 }, { time = 3, value = 3 }]";
    for (time, expected) in [(0.0, 2.0), (1.0, 1.0), (3.5, 2.5), (4.0, 2.0), (8.5, 1.5), (-0.5, 2.5)] {
        assert_eq!(zoom(track, time), expected, "{time}");
    }
    let ends = "loop = 4\ncamera.zoom = [{ time = 0, value = 1 }, { time = 2, value = 3 }, { time = 4, value = 1 }]";
    assert_eq!([0.0, 1.0, 3.0, 4.0].map(|time| zoom(ends, time)), [1.0, 2.0, 2.0, 1.0]);
}

#[test]
fn wind_repeats_a_whole_number_of_times_in_a_loop() {
    let mut scene = preset("fur").unwrap();
    scene.effect.wind = "breeze".into();
    for (period, expected) in [(6.0, 3.0), (4.0, 4.0), (1.5, 1.5), (9.0, 4.5)] {
        scene.animation.period = Some(period);
        assert_eq!(scene.check(&shader::shipped()).unwrap().number("wind_period"), expected, "{period}");
    }
}

#[test]
fn colors_mix_in_linear_light_and_lists_number_by_number() {
    let color = moving(
        "light.color = [{ time = 0, value = \"#000000\" }, { time = 1, value = \"#ffffff\" }]\n\
         camera.pan = [{ time = 0, value = [0, 1] }, { time = 1, value = [1, 0] }]\n\
         quality.samples = [{ time = 0, value = 10 }, { time = 1, value = 21 }]\n\
         camera.rotation = [{ time = 0, value = [0, 0, 0, 1] }, { time = 1, value = [0, 1, 0, 0] }]",
        0.5,
    )
    .unwrap();
    assert_eq!(color.light.color, crate::scene::Color([188; 3]), "sRGB of 1/2");
    assert_eq!((color.camera.pan, color.quality.samples), ([0.5, 0.5], 16));
    let half = std::f32::consts::FRAC_1_SQRT_2;
    assert!(color.camera.rotation.unwrap().iter().zip([0.0, half, 0.0, half]).all(|(a, b)| (a - b).abs() < 1e-6));
}

#[test]
fn an_expression_is_a_function_of_time() {
    let track = "parameters.fury = \"1 + sin(time * PI / 2)^2\"\ncamera.pan = [\"time / 2\", \"-1\"]";
    let scene = moving(track, 1.0).unwrap();
    assert_eq!(scene.parameters["fury"], ParameterValue::Number(2.0));
    assert_eq!(scene.camera.pan, [0.5, -1.0]);
}

#[test]
fn a_wrong_track_is_refused_in_one_line_that_says_where() {
    let key = |keys: &str| format!("camera.zoom = [{keys}]");
    for (animation, said) in [
        (key("{ time = 2, value = 1 }, { time = 1, value = 2 }"), "animation.camera.zoom.time = 1: must be later than"),
        (key("{ time = 2, value = 1 }, { time = 2, value = 2 }"), "animation.camera.zoom.time = 2: must be later than"),
        (key("{ time = nan, value = 1 }"), "animation.camera.zoom.time = NaN: must be from -1000000000 to"),
        (key("{ time = 0, value = inf }"), "animation.camera.zoom = inf at 0 s"),
        (key("{ time = 0, value = 1000 }"), "animation.camera.zoom = 1000 at 0 s: must be from 0.01 to 100"),
        (key("{ time = 0, value = 1 }, { time = 1, value = \"#ff0000\" }"), "all of one kind"),
        (key("{ time = 0, value = 1, ease = \"smoth\" }"), "did you mean `smooth`?"),
        (key("{ at = 0, value = 1 }"), "animation.camera.zoom: unknown field `at`"),
        (key(""), "animation.camera.zoom: must be keyframes"),
        ("camera.zoom = 3".into(), "animation.camera.zoom: must be keyframes"),
        ("loop = 2\n".to_string() + &key("{ time = 3, value = 1 }"), "time = 3: must be from 0 to 2 seconds"),
        ("loop = 2\n".to_string() + &key("{ time = 0, value = 1 }, { time = 2, value = 2 }"), "must be 1, as at 0 s"),
        ("loop = 0".into(), "animation.loop = 0: must be from 0.01"),
        ("loop = \"long\"".into(), "animation.loop is a number of seconds"),
        ("camera.zoom = \"1 / tme\"".into(), "`tme` is unknown"),
        ("camera.zoom = \"1 / time\"".into(), "must be finite, and is inf at 0 s"),
        ("camera.zoom = \"1 +\"".into(), "animation.camera.zoom = \"1 +\""),
        ("camera.zoom = \"200 + time\"".into(), "animation.camera.zoom = 200 at 0 s: must be from"),
        (format!("camera.zoom = \"{}\"", "(".repeat(1001)), "at most 1000 characters"),
        ("camera.zom = \"1\"".into(), "animation.camera.zom = a track: numbers and colors"),
        ("camera.time = \"1\"".into(), "animation.camera.time = a track"),
        ("object.input = \"1\"".into(), "animation.object.input = a track"),
        ("parameters.furi = \"1\"".into(), "no parameter `furi` (did you mean `fury`?)"),
        ("parameters.fury = [{ time = 1, value = 9 }]".into(), "parameters.fury = 9 at 1 s: must be from 0 to 4"),
    ] {
        let error = moving(&animation, 0.0).unwrap_err().to_string();
        assert!(error.contains(said) && !error.contains('\n'), "{animation}: {error}");
    }
}

#[test]
fn a_saved_animation_reads_back_and_a_field_sets_it() {
    let mut scene = preset("fire").unwrap();
    let before = to_text(&scene);
    assert!(!before.contains("animation"), "a scene at rest says nothing of it");
    scene.set_field("animation.parameters.fury", "[{ time = 0, value = 1 }, { time = 2.5, value = 3 }]").unwrap();
    scene.set_field("animation.light.color", "[{ time = 1, value = '#ff0000', ease = 'hold' }]").unwrap();
    scene.set_field("animation.camera.pan", "[\"sin(time)\", \"0\"]").unwrap();
    scene.set_field("animation.loop", "4").unwrap();
    assert_eq!(parse(&to_text(&scene), "saved").unwrap(), scene);
    for field in ["parameters.fury", "light.color", "camera.pan", "loop"] {
        scene.set_field(&format!("animation.{field}"), "").unwrap();
    }
    assert_eq!(to_text(&scene), before);
}
