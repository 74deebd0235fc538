//! Impulses with which cohesion pulls at contacts in a step, in scenes that call for it.

use super::StepContext;
use crate::contact::ContactGeometry;
use crate::groups::with_pairs;
use crate::lanes::Eight;
use crate::partition::TaskGroups;
use nalgebra::Vector3;

impl StepContext<'_> {
    /// Fills the pulls of a task whose contacts are laid out.
    pub(super) fn fill_pulls(&self, groups: &mut TaskGroups) {
        let StepContext { world, candidates, walls: placed, constants, .. } = self;
        let h = constants.scheme.step;
        let TaskGroups { pairs, pair_sources, pair_pulls, walls, wall_sources, wall_pulls, .. } = groups;
        with_pairs!(pairs, pairs => for ((group, sources), pulls) in pairs.iter().zip(pair_sources).zip(pair_pulls) {
            *pulls = Eight::default();
            for (lane, _) in sources.occupied() {
                let [i, j] = [group.first[lane] as usize, group.second[lane] as usize];
                let material = world.table.between_grains(world.materials[i], world.materials[j]);
                let geometry = world.pair_geometry(i, j);
                pulls.0[lane] = material.pull(geometry.effective_radius).impulse(geometry.gap, h);
            }
        });
        for ((group, sources), pulls) in walls.iter().zip(wall_sources).zip(wall_pulls) {
            *pulls = Eight::default();
            for (lane, candidate) in sources.occupied() {
                let (grain, surface) = (group.body[lane] as usize, candidates.walls[candidate].surface);
                let sphere = &world.spheres[grain];
                let (distance, normal) = placed.face(surface).nearest(&sphere.centre, Vector3::zeros);
                let geometry = ContactGeometry::with_wall(distance, normal.into(), sphere.radius);
                let material = world.wall_material(grain, surface);
                pulls.0[lane] = material.pull(geometry.effective_radius).impulse(geometry.gap, h);
            }
        }
    }
}
