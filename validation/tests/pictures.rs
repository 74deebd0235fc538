//! Pictures: what is where on them, in which colour, and files that others read.

use makadam::snapshot::{Particle, Snapshot};
use makadam_frames::output::RunFiles;
use makadam_frames::plan::MeasuredScene;
use makadam_frames::run_frames::{RunFrame, RunFrames, StoreWriter};
use makadam_view::pictures::{
    Animation, Camera, Cut, Picture, Scale, Style, Subject, VIRIDIS, View, camera, draw, has_scale, memory, write_png,
};
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

const SIZE: [usize; 2] = [320, 240];

fn scene() -> MeasuredScene {
    let text = r#"
        name = "three"
        description = "three grains in a box"
        duration = 1.0
        domain = { min = [-0.1, -0.1, -0.1], max = [0.1, 0.1, 0.1] }
        [material.glass]
        density = 2500.0
        youngs_modulus = 1e7
        poisson_ratio = 0.3
        friction = 0.5
        restitution = 0.5
        [[wall]]
        name = "box"
        material = "glass"
        shape = { kind = "box", min = [-0.05, -0.05, -0.02], max = [0.05, 0.05, 0.05], open = ["+z"] }
        [[grain]]
        material = "glass"
        radius = 0.01
        position = [0.0, 0.0, 0.0]
    "#;
    MeasuredScene::parse(text).unwrap()
}

/// A row of three grains along x whose speeds are 0, 1 and 2 m/s, and one at 2 m/s behind the first.
fn frame(folder: &Path, times: &[f64]) -> RunFrames {
    let grain = |id: u32, position: [f64; 3], speed: f64| Particle {
        id,
        position,
        radius: 0.01,
        velocity: [0.0, 0.0, speed],
        spin: [0.0; 3],
    };
    let mut writer = StoreWriter::create(&folder.join(RunFiles::FRAMES), &scene()).unwrap();
    for &time in times {
        let particles = vec![
            grain(0, [-0.03, 0.0, 0.0], 0.0),
            grain(1, [0.0, 0.0, 0.01 * time], 1.0),
            grain(2, [0.03, 0.0, 0.0], 2.0),
            grain(3, [-0.03, 0.03, 0.0], 2.0),
        ];
        writer.append(&Snapshot { time, particles, ..Snapshot::default() }).unwrap();
    }
    RunFrames::open(folder).unwrap()
}

fn style() -> Style {
    Style { size: SIZE, view: View::Angles([0.0, 0.0]), cut: None, walls: true }
}

fn picture(frame: &RunFrame, style: &Style) -> (Picture, Camera) {
    let camera = camera(&Subject::of(std::iter::once(frame), false), frame, style);
    let quantity = frame.quantity("speed").unwrap();
    (draw(frame, &quantity, &Scale::Range([0.0, 2.0]), &camera, style, "three"), camera)
}

/// Cosine of the angle between two colours: the same hue in another light.
fn alike(pixel: [u8; 3], colour: [u8; 3]) -> f64 {
    let [a, b] = [pixel, colour].map(|colour| colour.map(f64::from));
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    dot(a, b) / (dot(a, a) * dot(b, b)).sqrt()
}

#[test]
fn grains_stand_where_the_camera_has_them_in_the_colours_of_their_speeds() {
    let folder = tempfile::tempdir().unwrap();
    let frame = frame(folder.path(), &[0.0]).read(0).unwrap();
    let (drawn, camera) = picture(&frame, &style());
    assert_eq!((drawn.width, drawn.height, drawn.bytes.len()), (320, 240, 3 * 320 * 240));
    let at = |picture: &Picture, point: [f64; 3]| {
        let [x, y, depth] = camera.project(&point);
        assert!(depth > 0.0 && (0.0..320.0).contains(&x) && (0.0..240.0).contains(&y), "{x} {y} {depth}");
        picture.pixel(x as usize, y as usize)
    };
    let [slow, middle, fast] = [0, VIRIDIS.len() / 2, VIRIDIS.len() - 1].map(|stop| VIRIDIS[stop]);
    for (x, colour) in [(-0.03, slow), (0.0, middle), (0.03, fast)] {
        let pixel = at(&drawn, [x, 0.0, 0.0]);
        assert!(alike(pixel, colour) > 0.985, "{x}: {pixel:?} {colour:?}");
        // As wide as they are: the edge of a grain is inside, and what is next to it outside.
        let [inside, outside] = [0.9, 1.15].map(|share| at(&drawn, [x, 0.0, 0.01 * share]));
        assert!(alike(inside, colour) > 0.97, "{inside:?} {colour:?}");
        assert!(outside.iter().all(|share| *share > 150), "{outside:?}");
    }
    assert_eq!(drawn.pixel(160, 235), drawn.pixel(161, 235), "nothing but paper and glass below");
    // A plane through the first grain takes its front away, and one behind it all of it: then the grain behind is seen.
    let cut = |at| Style { cut: Some(Cut { axis: 1, at }), ..style() };
    let shown = |style: &Style| {
        let quantity = frame.quantity("speed").unwrap();
        draw(&frame, &quantity, &Scale::Range([0.0, 2.0]), &camera, style, "three")
    };
    assert!(alike(at(&shown(&cut(0.005)), [-0.03, 0.0, 0.0]), slow) > 0.985);
    let behind = at(&shown(&cut(0.015)), [-0.03, 0.03, 0.0]);
    assert!(alike(behind, fast) > 0.985, "{behind:?}");
    // Without walls there is paper where glass was.
    let bare = shown(&Style { walls: false, ..style() });
    let glass = [0.0, 0.045, 0.035];
    assert_eq!(at(&bare, glass), [255; 3]);
    assert!(at(&drawn, glass)[0] < 250);
}

#[test]
fn the_same_frame_gives_the_same_picture() {
    let folder = tempfile::tempdir().unwrap();
    let frame = frame(folder.path(), &[0.0]).read(0).unwrap();
    assert!(picture(&frame, &style()).0 == picture(&frame, &style()).0);
}

#[test]
fn files_are_read_by_others() {
    let folder = tempfile::tempdir().unwrap();
    let run = frame(folder.path(), &[0.0, 0.5, 1.0]);
    let pictures: Vec<Picture> = (0..3).map(|number| picture(&run.read(number).unwrap(), &style()).0).collect();
    let file = folder.path().join("one.png");
    write_png(&file, &pictures[0]).unwrap();
    let mut reader = png::Decoder::new(BufReader::new(File::open(&file).unwrap())).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    assert_eq!((info.width, info.height), (320, 240));
    assert!(bytes == pictures[0].bytes);

    let mut animation = Animation::begin(&folder.path().join("film.gif"), &pictures, 10.0).unwrap();
    pictures.iter().for_each(|picture| animation.push(picture).unwrap());
    animation.finish().unwrap();
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut reader = options.read_info(File::open(folder.path().join("film.gif")).unwrap()).unwrap();
    let mut count = 0;
    while let Some(frame) = reader.read_next_frame().unwrap() {
        assert_eq!((frame.width, frame.height, frame.delay), (320, 240, 10));
        // 256 colours are near to all that there are.
        let expected = pictures[count].bytes.chunks(3);
        let off = frame.buffer.chunks(4).zip(expected).map(|(a, b)| (0..3).map(|k| a[k].abs_diff(b[k])).max().unwrap());
        let off: Vec<u8> = off.collect();
        let mean = off.iter().map(|off| f64::from(*off)).sum::<f64>() / off.len() as f64;
        assert!(mean < 4.0, "frame {count} is off by {mean} on average");
        count += 1;
    }
    assert_eq!(count, 3);

    let message = write_png(&folder.path().join("one.jpg"), &pictures[0]).unwrap_err().to_string();
    assert!(message.contains("one.jpg") && message.contains(".png"), "{message}");
    let message = Animation::begin(&folder.path().join("film.mp4"), &pictures, 10.0).err().unwrap().to_string();
    assert!(message.contains("film.mp4") && message.contains(".gif"), "{message}");
}

#[test]
fn pictures_of_any_shape_are_drawn_and_narrow_ones_go_without_a_scale() {
    let folder = tempfile::tempdir().unwrap();
    let frame = frame(folder.path(), &[0.0]).read(0).unwrap();
    for size in [[64, 64], [64, 200], [110, 64], [200, 64], [150, 150]] {
        let (drawn, camera) = picture(&frame, &Style { size, ..style() });
        let [x, y, _] = camera.project(&[0.03, 0.0, 0.0]);
        let pixel = drawn.pixel(x as usize, y as usize);
        assert!(alike(pixel, VIRIDIS[VIRIDIS.len() - 1]) > 0.95, "{size:?}: {pixel:?}");
    }
    assert_eq!([[64, 200], [200, 64], [160, 120]].map(has_scale), [false, true, true]);
    assert!(memory([16_384, 16_384]) > 30_000_000_000 && memory([800, 600]) < 100_000_000);
}

#[test]
fn grains_that_have_left_the_walls_far_behind_are_not_waited_for() {
    let folder = tempfile::tempdir().unwrap();
    let mut frame = frame(folder.path(), &[0.0]).read(0).unwrap();
    // Two of four have fallen by five metres.
    frame.grains.positions[0][2] = -5.0;
    frame.grains.positions[3][2] = -5.1;
    let seen = |point: [f64; 3], all: bool| {
        let camera = camera(&Subject::of(std::iter::once(&frame), all), &frame, &style());
        let [x, y, depth] = camera.project(&point);
        let wide = camera.pixels(0.02, depth);
        (depth > 0.0 && (0.0..320.0).contains(&x) && (0.0..240.0).contains(&y)).then_some(wide)
    };
    for corner in [[-0.05, -0.05, -0.02], [0.05, 0.05, 0.05]] {
        assert!(seen(corner, false).is_some_and(|wide| wide > 10.0), "the box is seen whole");
    }
    assert!(seen([0.0; 3], false).is_some() && seen([-0.03, 0.0, -5.0], false).is_none());
    assert!(
        seen([-0.03, 0.03, -5.1], true).is_some_and(|wide| wide < 2.0),
        "all grains are seen where that is asked for"
    );
    // Where none is left, there are the walls.
    let folder = tempfile::tempdir().unwrap();
    let mut empty = self::frame(folder.path(), &[0.0]).read(0).unwrap();
    empty.grains.positions.iter_mut().for_each(|position| position[2] = -9.0);
    let camera = camera(&Subject::of(std::iter::once(&empty), false), &empty, &style());
    let [x, y, _] = camera.project(&[0.05, 0.05, 0.05]);
    assert!((100.0..320.0).contains(&x) && (0.0..240.0).contains(&y), "{x} {y}");
}

#[test]
fn an_animation_that_is_not_finished_leaves_nothing_and_says_how_fast_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let frames = tempfile::tempdir().unwrap();
    let frame = frame(frames.path(), &[0.0]).read(0).unwrap();
    let drawn = [picture(&frame, &style()).0];
    for (name, rate, each) in [("a.gif", 1e9, 0.01), ("a.gif", 20.0, 0.05)] {
        let mut animation = Animation::begin(&folder.path().join(name), &drawn, rate).unwrap();
        animation.push(&drawn[0]).unwrap();
        assert!((animation.seconds_per_frame() - each).abs() < 1e-9, "{name}");
        drop(animation);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "{name}");
    }
}

#[test]
fn views_and_planes_are_read_from_words() {
    assert_eq!("30,-20.5".parse::<View>().unwrap(), View::Angles([30.0, -20.5]));
    assert_eq!("top".parse::<View>().unwrap(), View::Angles([0.0, 90.0]));
    assert!("above".parse::<View>().unwrap_err().contains("front, side, top"));
    assert_eq!("y=-0.02".parse::<Cut>().unwrap(), Cut { axis: 1, at: -0.02 });
    assert!("w=1".parse::<Cut>().unwrap_err().contains("y=0.02"));
}

#[test]
fn from_above_the_vertical_points_at_the_eye() {
    let folder = tempfile::tempdir().unwrap();
    let frame = frame(folder.path(), &[0.0]).read(0).unwrap();
    let top = Style { view: View::Angles([0.0, 90.0]), ..style() };
    let camera = camera(&Subject::of(std::iter::once(&frame), false), &frame, &top);
    let [_, low, far] = camera.project(&[0.0, 0.0, 0.0]);
    let [_, high, near] = camera.project(&[0.0, 0.03, 0.03]);
    assert!(near < far, "what is higher is nearer");
    assert!(high < low, "the front is at the lower edge");
}
