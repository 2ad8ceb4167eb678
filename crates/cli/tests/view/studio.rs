//! The window as a studio: lesson, menus, grooms and keyframes.

use super::{Display, assert_good, play, program};
use hypertexture::glam::Vec3;
use hypertexture::scene::{self, Reach};
use hypertexture::shape::Groom;
use std::path::Path;

#[test]
#[cfg_attr(any(no_gpu, no_display), ignore = "HYPERTEXTURE_NO_GPU or HYPERTEXTURE_NO_DISPLAY is set")]
fn a_lesson_measures_turbulence_and_its_scene_is_saved() {
    let display = Display::new();
    let folder = tempfile::tempdir().unwrap();
    let saved = folder.path().join("lesson.toml");
    let script = format!(
        "wait picture\nkey L\nframes 2\nclick lesson.held\nset lesson.count 12\nwait converged\nclick lesson.density\n\
         frames 3\nclick lesson.add biased\nclick lesson.turbulence\nframes 2\nset lesson.octaves 3\nwait drawn\nclick lesson.measure\n\
         frames 2\nwait idle\nframes 2\nclick lesson.use channels\nclick File\nframes 2\n\
         write file.scene {}\nclick file.save\nquit\n",
        saved.display()
    );
    let scene = ["sphere", "--effect", "fire", "--size", "32x24", "--window", "1200x560", "--supersampling", "4"];
    play(&display, folder.path(), &scene, &script);
    let scene = scene::load(&saved, Reach::Anywhere).unwrap();
    let (quality, effect) = (&scene.quality, &scene.effect);
    assert_eq!((quality.samples, quality.supersampling, effect.octaves), (12, 1, 3));
    assert_eq!((effect.turbulence.as_str(), effect.dmf.last().map(String::as_str)), ("channels", Some("biased")));
}

#[test]
#[cfg_attr(any(no_gpu, no_display), ignore = "HYPERTEXTURE_NO_GPU or HYPERTEXTURE_NO_DISPLAY is set")]
fn menus_do_what_keys_do_and_a_scene_leaves_as_mesh_and_volume() {
    let display = Display::new();
    let folder = tempfile::tempdir().unwrap();
    let [mesh, volume, direct, page, pages] =
        ["a.ply", "a.npy", "b.ply", "a.html", "pages"].map(|name| folder.path().join(name));
    let export = |kind: &str, file: &Path| {
        format!(
            "click final.{kind}\nwrite final.file {}\n{}frames 2\nclick final.render\nwait idle\n",
            file.display(),
            if kind == "page" { "" } else { "set final.grid 24\n" }
        )
    };
    let script = format!(
        "wait picture\nclick menu Help\nframes 3\nclick menu Keys\nframes 3\nwrite help.search light\nkey Esc\nkey Esc\n\
         click menu File\nframes 3\nclick menu Export...\nframes 3\n{}{}{}{}quit\n",
        export("mesh", &mesh),
        export("volume", &volume),
        export("page", &page),
        export("page", &pages)
    );
    let scene = ["torus", "--effect", "lit", "--size", "96x64"];
    play(&display, folder.path(), &[&scene[..], &["--window", "1200x900"]].concat(), &script);
    let mesh_command = ["mesh", "torus", "--effect", "lit", "--grid", "24", "--output", direct.to_str().unwrap()];
    assert_good(&program().args(mesh_command).output().unwrap());
    assert_eq!(std::fs::read(&mesh).unwrap(), std::fs::read(&direct).unwrap(), "the mesh of the command");
    assert!(std::fs::read(&volume).unwrap().starts_with(b"\x93NUMPY"));
    let web_command = ["web", "torus", "--effect", "lit", "--size", "96x64", "--output", "direct"];
    assert_good(&program().args(web_command).current_dir(folder.path()).output().unwrap());
    let files = std::fs::read_dir(folder.path().join("direct")).unwrap().map(|file| file.unwrap().path());
    for file in files.filter(|file| file.extension().is_some_and(|end| end == "wgsl" || end == "json")) {
        let own = std::fs::read_to_string(pages.join(file.file_name().unwrap())).unwrap();
        let direct = std::fs::read_to_string(&file).unwrap();
        assert!(own == direct.replace("-o direct", "-o pages"), "{}", file.display());
    }
    let text = std::fs::read_to_string(&page).unwrap();
    assert!(text.contains("hypertexture web torus") && text.contains("--single-file -o a.html"));
}

#[test]
#[cfg_attr(any(no_gpu, no_display), ignore = "HYPERTEXTURE_NO_GPU or HYPERTEXTURE_NO_DISPLAY is set")]
fn a_stroke_is_one_undo_step_saved_beside_the_scene() {
    let (display, folder) = (Display::new(), tempfile::tempdir().unwrap());
    let file = folder.path().join("cut.toml");
    let script = format!(
        "wait drawn\nclick Groom\nframes 3\nclick brush.cut\nframes 2\ndrag 0.45 0.5 0.55 0.5\nwait drawn\n\
         drag 0.5 0.4 0.5 0.6\nwait drawn\nkey Z\nframes 2\nclick File\nframes 2\nwrite file.scene {}\n\
         click file.save\nframes 3\nquit\n",
        file.display()
    );
    play(&display, folder.path(), &["sphere", "--camera", "0,0", "--window", "900x600"], &script);
    let scene = scene::load(&file, Reach::Beside).unwrap();
    assert_eq!(scene.camera.rotation, None, "a stroke turns nothing");
    let groom = Groom::read(Path::new(&scene.groom.unwrap())).unwrap();
    let cut = (0..groom.voxels()).filter(|index| groom.at(*index) != Groom::NEUTRAL).map(|index| groom.place(index));
    let (low, high) = cut.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
    // Along x on the front of the ball, by a brush of radius 0.15; without the stroke along y.
    assert!(high.x - low.x > 0.35 && high.z > 0.9 && low.y > -0.16 && high.y < 0.16, "{low} to {high}");
}

#[test]
#[cfg_attr(any(no_gpu, no_display), ignore = "HYPERTEXTURE_NO_GPU or HYPERTEXTURE_NO_DISPLAY is set")]
fn keyframes_are_set_where_the_timeline_is_and_saved() {
    let display = Display::new();
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.toml").display().to_string();
    let script = format!(
        "wait picture\nclick timeline keyframes\nframes 2\nclick parameters.fury.keyframe\nframes 2\nset timeline 2\n\
         frames 2\nset parameters.fury 3\nframes 2\nset timeline 1\nwait picture\nclick File\nframes 2\n\
         write file.scene {scene}\nclick file.save\nframes 3\nquit\n"
    );
    let small = ["torus", "--effect", "fire", "--samples", "32", "--size", "64x48", "--window", "640x400"];
    play(&display, folder.path(), &small, &script);
    let saved = scene::load(Path::new(&scene), Reach::Anywhere).unwrap();
    let Some(scene::Track::Keys(keys)) = saved.animation.tracks.get("parameters.fury") else { panic!("no keyframes") };
    assert_eq!(keys.iter().map(|key| key.time).collect::<Vec<_>>(), [0.0, 2.0]);
    let fury = &saved.moment().unwrap().parameters["fury"];
    assert_eq!(*fury, scene::ParameterValue::Number(2.25), "at the time of the timeline, 1 s");
}

#[test]
#[cfg_attr(any(no_gpu, no_display), ignore = "HYPERTEXTURE_NO_GPU or HYPERTEXTURE_NO_DISPLAY is set")]
fn a_drag_on_an_axis_moves_along_it_and_a_number_is_typed() {
    let (display, folder) = (Display::new(), tempfile::tempdir().unwrap());
    let files = ["dragged", "typed", "turned", "lit"].map(|name| folder.path().join(format!("{name}.toml")));
    let save = |number: usize| {
        format!("write file.scene {}\nclick file.save\nframes 3\nkey Esc\nframes 2\n", files[number].display())
    };
    // The picture has about 560 points across, an axis 80.
    let script = format!(
        "wait drawn\nclick File\nclick Objects\nframes 2\nclick object b\nkey G\nframes 2\ndrag 0.58 0.5 0.7 0.6\n\
         frames 2\n{}type 0.25\nkey Enter\nframes 2\n{}type -9\nkey Backspace\nkey Backspace\nkey Z\nframes 2\n\
         click object main\nframes 2\ndrag 0.5 0.5 0.6 0.5\nframes 2\n{}type 7\nkey Enter\nframes 2\n{}quit\n",
        save(0),
        save(1),
        save(2),
        save(3)
    );
    let place = ["--set", "parts.b={}", "--set", "parts.b.object.input=sphere", "--set", "parts.b.transform.scale=0.5"];
    let scene = ["sphere", "--camera", "0,0", "--samples", "32", "--window", "900x600"];
    play(&display, folder.path(), &[&scene[..], &place].concat(), &script);
    let [dragged, typed, turned, lit] = files.map(|file| scene::load(&file, Reach::Anywhere).unwrap());
    let at = |scene: &scene::Scene| scene.parts["b"].transform.at;
    let [x, y, z] = at(&dragged);
    assert!(x > 0.2 && y.abs() < 1e-6 && z.abs() < 1e-6, "only along x: {:?}", at(&dragged));
    assert_eq!(at(&typed), [x + 0.25, y, z]);
    assert_eq!(at(&turned), at(&dragged), "undone as one step");
    let light = |scene: &scene::Scene| Vec3::from(scene.light.position);
    assert!((light(&turned).length() - light(&dragged).length()).abs() < 1e-4);
    assert!(light(&turned).distance(light(&dragged)) > 0.5, "around the object");
    assert!((light(&lit) - 7.0 * light(&turned).normalize()).length() < 1e-4);
}
