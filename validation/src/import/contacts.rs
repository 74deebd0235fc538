//! From a code's contact list to the one that is measured.

use crate::recording::LARGEST;
use makadam::snapshot::{Contact, Partner, Snapshot};
use nalgebra::Vector3;

/// Contacts of one grain with one wall are one contact if their normals are closer than this (cosine of 15 degrees):
/// more than the few degrees by which the edge of a neighbouring triangle leans, less than any corner of a container.
const SAME_FACE: f64 = 0.966;

/// Merges the contacts that a grain has with several triangles of one face of a wall; forces are summed.
pub fn merge_wall_contacts(contacts: Vec<Contact>) -> Vec<Contact> {
    let mut merged: Vec<Contact> = Vec::with_capacity(contacts.len());
    let mut last_of = std::collections::HashMap::<(u32, u32), Vec<usize>>::new();
    for contact in contacts {
        let Partner::Wall(wall) = contact.second else {
            merged.push(contact);
            continue;
        };
        let places = last_of.entry((contact.first, wall)).or_default();
        let normal = Vector3::from(contact.normal);
        match places.iter().find(|&&place| Vector3::from(merged[place].normal).dot(&normal) > SAME_FACE) {
            Some(&place) => merged[place] = sum(&merged[place], &contact),
            None => {
                places.push(merged.len());
                merged.push(contact);
            }
        }
    }
    merged
}

fn sum(a: &Contact, b: &Contact) -> Contact {
    let force = |contact: &Contact| {
        Vector3::from(contact.normal) * contact.normal_force + Vector3::from(contact.tangential_force)
    };
    let (share_a, share_b) = match a.normal_force.abs() + b.normal_force.abs() {
        total if total > 0.0 => (a.normal_force.abs() / total, b.normal_force.abs() / total),
        _ => (0.5, 0.5),
    };
    let mean = |x: [f64; 3], y: [f64; 3]| Vector3::from(x) * share_a + Vector3::from(y) * share_b;
    let normal = mean(a.normal, b.normal).normalize();
    let total = force(a) + force(b);
    let normal_force = total.dot(&normal);
    Contact {
        first: a.first,
        second: a.second,
        point: mean(a.point, b.point).into(),
        normal: normal.into(),
        normal_force,
        tangential_force: (total - normal * normal_force).into(),
    }
}

/// The frame, if its contacts are numbers that forces can be: huge ones pass as numbers in a file, and overflow in products.
pub(crate) fn measurable(frame: Snapshot) -> Result<Snapshot, String> {
    let finite = |contact: &Contact| {
        let vectors = [contact.normal, contact.tangential_force, contact.point];
        contact.normal_force.abs() < LARGEST && vectors.iter().flatten().all(|component| component.abs() < LARGEST)
    };
    match frame.contacts.iter().find(|contact| !finite(contact)) {
        None => Ok(frame),
        Some(contact) => Err(format!("a force on grain {} is beyond all numbers: the run has blown up", contact.first)),
    }
}

/// A contact from the force on its first grain; `None` if it bears none.
pub(crate) fn contact_from_force(
    first: u32,
    second: Partner,
    point: [f64; 3],
    normal: Vector3<f64>,
    force_on_first: Vector3<f64>,
) -> Option<Contact> {
    if force_on_first == Vector3::zeros() {
        return None;
    }
    let on_partner = -force_on_first;
    let normal_force = on_partner.dot(&normal);
    Some(Contact {
        first,
        second,
        point,
        normal: normal.into(),
        normal_force,
        tangential_force: (on_partner - normal * normal_force).into(),
    })
}
