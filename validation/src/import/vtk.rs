//! Frames in VTK's XML files (`.vtp`, `.vtu`): points and arrays over them, or lines and arrays over them.

use super::arrays::{Named, is_wanted, table_of};
use super::frame_table::{FrameTable, ImportError};
use super::stated::StatedColumns;
use crate::output::vtk::Array;
use crate::output::{DRIVEN_WALLS, FIELD_DATA, driven_walls, outline_vtk};
use std::path::Path;

/// Files that list others: the root's type, and what to give instead.
const LISTS: [(&str, &str); 5] = [
    ("Collection", "it is a list of files (.pvd); give the files that it lists, or the folder of a run of Makadam"),
    ("vtkMultiBlockDataSet", "it is a list of blocks (.vtm); give the files that it lists, one frame each"),
    ("vtkPartitionedDataSetCollection", "it is a list of blocks (.vtpc); give the files that it lists, one frame each"),
    ("PPolyData", "it is a list of pieces (.pvtp); merge them (in ParaView: filter Merge Blocks) and write .vtp"),
    (
        "PUnstructuredGrid",
        "it is a list of pieces (.pvtu); merge them (in ParaView: filter Merge Blocks) and write .vtu",
    ),
];

/// The frame in an XML file of polygonal data or of an unstructured grid: its points, or its lines, if it has some.
///
/// # Errors
/// [`ImportError`].
pub(super) fn xml(file: &Path, bytes: &[u8], stated: &StatedColumns) -> Result<Vec<FrameTable>, ImportError> {
    let fault = |problem: String| ImportError::new(file, 1, problem);
    let head = String::from_utf8_lossy(&bytes[..bytes.len().min(1000)]);
    if let Some((_, problem)) = LISTS.iter().find(|(kind, _)| head.contains(&format!("type=\"{kind}\""))) {
        return Err(fault((*problem).into()));
    }
    let heads = outline_vtk(bytes, &|_, _| false).map_err(fault)?;
    let told = |section: &str| heads.unread.iter().any(|(name, ..)| *name == section);
    // A frame without contacts has no lines, and is told by what it says of them.
    let lines = heads.topology == "Lines" || (heads.points == 0 && !told("PointData") && told("CellData"));
    let (sections, count) =
        if lines { (&["CellData"][..], heads.cells) } else { (&["Points", "PointData"][..], heads.points) };
    let named = |section: &str, name: &str| if section == "Points" { "points".to_string() } else { name.to_string() };
    let is_read = |section: &str, name: &str| {
        let components = heads.unread.iter().find(|(of, known, _)| *of == section && known == name);
        let components = components.map_or(1, |(.., components)| *components);
        let is_pose = section == FIELD_DATA && DRIVEN_WALLS.contains(&name);
        is_pose || sections.contains(&section) && is_wanted(&named(section, name), components, stated)
    };
    let outline = outline_vtk(bytes, &is_read).map_err(fault)?;
    let of_section = |section: &str| sections.contains(&section);
    let read = outline.sections.iter().filter(|(section, _)| of_section(section)).flat_map(|(section, arrays)| {
        arrays.iter().map(move |array| Named::new(named(section, &array.name), array.components, Some(array.values())))
    });
    let unread = outline.unread.iter().filter(|(section, ..)| of_section(section));
    let unread = unread.map(|(section, name, components)| Named::new(named(section, name), *components, None));
    let arrays: Vec<Named> = read.chain(unread).collect();
    let first_id = outline.of_run.then_some(0);
    let of_whole =
        || outline.sections.iter().filter(|(section, _)| *section == FIELD_DATA).flat_map(|(_, arrays)| arrays);
    let pose = |name: &str| of_whole().find(|array| array.name == name).map(Array::values);
    let driven_walls = if outline.of_run { driven_walls(pose).map_err(fault)? } else { Vec::new() };
    Ok(vec![FrameTable { time: outline.time, first_id, driven_walls, ..table_of(file, count, &arrays, stated)? }])
}
