//! Unit tests of `src/scenes/change.rs`.

use super::*;
use makadam_frames::plan::MeasuredScene;

fn drum() -> String {
    crate::scenes::text(&crate::scenes::find("drum", &[]).unwrap()).unwrap()
}

fn with(changes: &[&str]) -> Result<MeasuredScene, ChangeError> {
    let changes: Vec<Change> = changes.iter().map(|change| change.parse().unwrap()).collect();
    Ok(MeasuredScene::parse(&changed(&drum(), Path::new(""), &changes)?).unwrap())
}

#[test]
fn a_value_is_set_where_it_stands_and_lines_keep_their_numbers() {
    let scene = with(&["material.grain.friction=0.25", "wall.shell.motion.rate=2", "duration=4"]).unwrap();
    assert_eq!((scene.material["grain"].friction, scene.duration), (0.25, 4.0));
    assert!(matches!(scene.wall[0].motion, makadam::Motion::Rotating { rate: 2.0, .. }));
    let change = ["material.grain.friction=0.25".parse::<Change>().unwrap()];
    let (before, after) = (drum(), changed(&drum(), Path::new(""), &change).unwrap());
    assert_eq!(before.lines().count(), after.lines().count());
    let other: Vec<_> = before.lines().zip(after.lines()).filter(|(a, b)| a != b).collect();
    assert_eq!(other, [("friction = 0.5", "friction = 0.25")]);
}

#[test]
fn tables_that_the_text_leaves_out_come_into_being() {
    let scene = with(&["output.interval=0.5", "watch.on_escape=ignore"]).unwrap();
    assert_eq!(scene.output_interval(), 0.5);
    assert_eq!(scene.watch.on_escape, makadam::scene::Reaction::Ignore);
    assert!(with(&["outputs.interval=0.5"]).unwrap_err().to_string().contains("output"), "a name that is none");
}

#[test]
fn what_the_text_leaves_out_begins_with_its_default() {
    let scene = with(&["solver.stop.sweeps=20", "solver.step=1e-3"]).unwrap();
    assert_eq!(scene.solver.stop, makadam::scene::Stop::Sweeps { sweeps: 20 });
    assert_eq!(scene.solver.step, 1e-3);
    assert_eq!(with(&["solver.method.kind=jacobi"]).unwrap().solver.method.name(), "jacobi");
}

#[test]
fn an_entry_is_found_by_name_by_number_or_by_being_alone() {
    for key in ["population.count", "population.0.count", "population[0].count"] {
        assert_eq!(with(&[&format!("{key}=500")]).unwrap().population[0].count, 500, "{key}");
    }
    assert_eq!(with(&["wall.front cap.material=shell"]).unwrap().wall[1].material, "shell");
    assert_eq!(with(&["compare.gini.margin=0.5"]).unwrap().compare[3].margin, Some(0.5));
    for key in ["gravity.2", "gravity[2]"] {
        assert_eq!(with(&[&format!("{key}=-1.62")]).unwrap().gravity[2], -1.62, "{key}");
    }
    assert_eq!(key_of("wall[1].shape.centres[2][0]"), ["wall", "1", "shape", "centres", "2", "0"]);
    assert_eq!(key_of("wall.\"a[0].b\".material"), ["wall", "a[0].b", "material"]);
}

#[test]
fn what_leads_nowhere_is_refused_in_words() {
    for (change, words) in [
        ("wall.material=shell", "wall has 3 entries: say which, such as wall.shell"),
        ("population[1].count=5", "population has 1 entries: say which, such as population.0"),
        ("duration.x=1", "duration is a value"),
        ("materail.grain.friction=1", "did you mean material?"),
        ("material.grian.friction=1", "the scene has no 'material.grian'; did you mean grain?"),
        ("mesh.file=a.stl", "a wall of a CAD file is"),
    ] {
        let message = with(&[change]).unwrap_err().to_string();
        assert!(message.contains(words) && message.contains(change), "{message}");
    }
    for written in ["friction", "=1", "a..b=1", "duration="] {
        assert!(written.parse::<Change>().unwrap_err().to_string().contains("KEY=VALUE"), "{written}");
    }
}
