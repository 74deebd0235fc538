//! Impulses with which cohesion pulls at contacts in a step, in scenes that call for it.

use super::Given;
use crate::groups::with_pairs;
use crate::lanes::Eight;
use crate::partition::TaskGroups;

impl Given<'_> {
    /// Fills the pulls of a task whose contacts are laid out.
    pub(super) fn fill_pulls(&self, groups: &mut TaskGroups) {
        let Given { world, candidates, poses, constants, .. } = self;
        let h = constants.scheme.step;
        let TaskGroups { pairs, pair_sources, pair_pulls, walls, wall_sources, wall_pulls, .. } = groups;
        with_pairs!(pairs, pairs => for ((group, sources), pulls) in pairs.iter().zip(pair_sources).zip(pair_pulls) {
            *pulls = Eight::default();
            for (lane, _) in sources.occupied() {
                let [i, j] = [group.first[lane] as usize, group.second[lane] as usize];
                let (a, b) = (&world.spheres[i], &world.spheres[j]);
                let material = world.table.between_grains(world.materials[i], world.materials[j]);
                let gap = world.arm(i, j).norm() - a.radius - b.radius;
                pulls.0[lane] = material.pull(a.radius * b.radius / (a.radius + b.radius)).impulse(gap, h);
            }
        });
        for ((group, sources), pulls) in walls.iter().zip(wall_sources).zip(wall_pulls) {
            *pulls = Eight::default();
            for (lane, candidate) in sources.occupied() {
                let (grain, surface) = (group.body[lane] as usize, candidates.walls[candidate].surface as usize);
                let sphere = &world.spheres[grain];
                let material = world.table.with_wall(world.materials[grain], world.surfaces[surface].material);
                let gap = poses[surface].distance(&sphere.centre) - sphere.radius;
                pulls.0[lane] = material.pull(sphere.radius).impulse(gap, h);
            }
        }
    }
}
