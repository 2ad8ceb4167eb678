//! Animated files, read by decoders.

use super::*;
use std::fs::File;
use std::io::{BufReader, Cursor};

/// Frames of 5 x 3 pixels with a moving opaque pixel on transparent ones, in PNG files.
fn frames(folder: &Path) -> (Vec<RgbaImage>, Vec<PathBuf>) {
    let frame = |number: u32| {
        RgbaImage::from_fn(5, 3, |x, y| match (x + y) % 5 == number {
            true => image::Rgba([250, 40 * number as u8, 7, 255]),
            false => image::Rgba([0; 4]),
        })
    };
    let frames: Vec<RgbaImage> = (0..3).map(frame).collect();
    let files: Vec<PathBuf> = (0..3).map(|number| folder.join(format!("f_{number:04}.png"))).collect();
    frames.iter().zip(&files).for_each(|(frame, file)| frame.save(file).unwrap());
    (frames, files)
}

#[test]
fn a_webp_has_the_pixels_and_times_of_its_frames() {
    let folder = tempfile::tempdir().unwrap();
    let (frames, files) = frames(folder.path());
    let path = folder.path().join("a.webp");
    Animated::of(&path).unwrap().write(&files, 30.0, &path).unwrap();
    let mut decoder = image_webp::WebPDecoder::new(BufReader::new(File::open(&path).unwrap())).unwrap();
    assert_eq!((decoder.dimensions(), decoder.num_frames(), decoder.has_alpha()), ((5, 3), 3, true));
    assert_eq!(decoder.loop_count(), image_webp::LoopCount::Forever);
    for (frame, ms) in frames.iter().zip([33, 34, 33]) {
        let mut pixels = vec![0; 5 * 3 * 4];
        assert_eq!(decoder.read_frame(&mut pixels).unwrap(), ms);
        assert_eq!(pixels, frame.as_raw()[..]);
    }
}

#[test]
fn an_apng_has_the_pixels_and_the_rate_of_its_frames() {
    let folder = tempfile::tempdir().unwrap();
    let (frames, files) = frames(folder.path());
    let path = folder.path().join("a.apng");
    Animated::of(&path).unwrap().write(&files, 29.97, &path).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info().unwrap();
    let control = reader.info().animation_control().copied().unwrap();
    assert_eq!((control.num_frames, control.num_plays), (3, 0));
    for frame in &frames {
        let mut pixels = vec![0; 5 * 3 * 4];
        reader.next_frame(&mut pixels).unwrap();
        let control = reader.info().frame_control().copied().unwrap();
        assert_eq!((control.delay_num, control.delay_den), (1000, 29970));
        assert_eq!(pixels, frame.as_raw()[..]);
    }
}

#[test]
fn a_gif_has_its_few_colors_and_repeats() {
    let folder = tempfile::tempdir().unwrap();
    let (frames, files) = frames(folder.path());
    let path = folder.path().join("a.gif");
    Animated::of(&path).unwrap().write(&files, 30.0, &path).unwrap();
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut decoder = options.read_info(File::open(&path).unwrap()).unwrap();
    for (frame, hundredths) in frames.iter().zip([3, 4, 3]) {
        let read = decoder.read_next_frame().unwrap().unwrap();
        assert_eq!(read.delay, hundredths);
        for (found, pixel) in read.buffer.chunks(4).zip(frame.pixels()) {
            assert!(found[3] == pixel.0[3] && (found[3] == 0 || found == pixel.0), "{found:?} for {pixel:?}");
        }
    }
    assert_eq!(decoder.repeat(), gif::Repeat::Infinite);
}

#[test]
fn a_gif_has_no_frame_below_20_ms_and_keeps_its_speed() {
    for (count, fps) in [(60, 60.0), (7, 60.0), (500, 1000.0), (3, 1000.0), (100, 50.0), (90, 45.0), (240, 239.76)] {
        let frames = gif_frames(count, fps);
        assert!(
            frames.iter().all(|(frame, hundredths)| *frame < count && *hundredths >= 2),
            "{count} at {fps}: {frames:?}"
        );
        assert!(frames.windows(2).all(|pair| pair[0].0 < pair[1].0), "{count} at {fps}: {frames:?}");
        let seconds = frames.iter().map(|(_, hundredths)| f64::from(*hundredths) / 100.0).sum::<f64>();
        assert!((seconds - count as f64 / fps).abs() <= 0.02, "{count} at {fps}: {seconds} s");
        // Each frame is shown at its time, to half a tick or half a frame.
        let starts = frames.iter().scan(0, |at, (frame, own)| Some((*frame, std::mem::replace(at, *at + own))));
        for (frame, hundredths) in starts {
            let late = f64::from(hundredths) / 100.0 - frame as f64 / fps;
            assert!(late.abs() <= 0.0101_f64.max(0.5 / fps), "{count} at {fps}: frame {frame} by {late}");
        }
    }
    assert!(Animated::Gif.note(60.0).unwrap().contains("at most 50 frames a second"));
    assert!([Animated::Gif, Animated::WebP, Animated::Apng].iter().all(|format| format.note(50.0).is_none()));
}

#[test]
fn a_sheet_has_its_frames_where_its_json_says() {
    let folder = tempfile::tempdir().unwrap();
    let (frames, files) = frames(folder.path());
    let path = folder.path().join("sheet.png");
    let sheet: Sheet = "2x2".parse().unwrap();
    sheet.write(&files, 25.0, Some(4.0), &path).unwrap();
    let whole = image::open(&path).unwrap().to_rgba8();
    let places: serde_json::Value = serde_json::from_slice(&std::fs::read(Sheet::places(&path)).unwrap()).unwrap();
    assert_eq!((whole.dimensions(), &places["meta"]["loop"]), ((10, 6), &json!(4.0)));
    for (frame, place) in frames.iter().zip(places["frames"].as_array().unwrap()) {
        let at = |side: &str| place["frame"][side].as_u64().unwrap() as u32;
        let part = image::imageops::crop_imm(&whole, at("x"), at("y"), at("w"), at("h")).to_image();
        assert_eq!((&part, &place["duration"]), (frame, &json!(40)));
    }
    assert!(sheet.check(5, [4, 4]).unwrap_err().ends_with("holds 4 frames, and --frames has 5"));
    assert!(sheet.check(4, [4, 9000]).unwrap_err().contains("has 8 x 18000 pixels"));
    assert!(["8", "0x8", "8x", "8x8x8", "9999x1"].iter().all(|text| text.parse::<Sheet>().is_err()));
}
