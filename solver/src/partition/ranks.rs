//! Division of a run among ranks, with the bits of one rank.
//!
//! A rank owns whole boxes, and a task belongs to the rank of its home box: the rank searches, constrains and relaxes its contacts, and holds
//! their impulses. All ranks hold all grains. A grain near a border is in tasks of several ranks, in at most one of each stage, so that
//! its velocity goes from rank to rank in the order of the stages:
//!
//! ```text
//! before a stage    the velocity of each grain that a task of this rank is about to change, from the rank that changed it last
//! after the sweeps  the velocity of each grain, from the rank that changed it last, to all ranks
//! sums              terms of all ranks, added in the order of the tasks of the whole plan
//! ```
//!
//! So every contact is relaxed with the velocities that it would find on one rank, and no sum depends on the ranks.

use super::{BoxGrid, Plan, PlannedTask, STAGES};
use crate::lanes::TaskSlots;
use crate::messages::{Messages, Timed};
use bytemuck::{Pod, Zeroable};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::ops::Range;
use std::sync::{Arc, Mutex, MutexGuard};

/// Stage of the contacts with dynamic walls, after all others.
pub(crate) const DRIVEN_STAGE: usize = STAGES;

/// Ranks of a run, and the part of this one.
#[derive(Clone, Debug)]
pub(crate) struct Ranks {
    messages: Arc<Timed>,
    /// Rank of each box.
    owners: Vec<u16>,
    /// Rank of each successive task of the whole plan.
    sequence: Vec<u16>,
    /// Work of each box: candidates of its tasks.
    work: Vec<u32>,
    /// Velocities that go from rank to rank before each stage.
    before: [Links; STAGES + 1],
    /// Grains of each rank: those whose velocities it has changed last.
    held: Vec<Grains>,
    /// Ranks that relax contacts with dynamic walls in turn, and numbers of contacts.
    turns: Vec<(usize, usize)>,
    /// True if every rank has the impulses of all contacts: after a start or a change of stage, until the next build of the list.
    pub complete: bool,
    /// True during a step.
    pub is_in_step: bool,
    /// Number of interventions in the simulation after the last step.
    pub interventions: u64,
}

/// Grains that are sent to other ranks and received from them, by rank.
#[derive(Clone, Debug, Default)]
struct Links {
    sent: Vec<(usize, Grains)>,
    received: Vec<(usize, Grains)>,
}

/// Grains in runs of body indices, and a buffer for their velocities.
#[derive(Debug, Default)]
struct Grains {
    runs: Vec<Range<u32>>,
    buffer: Mutex<Vec<u8>>,
}

impl Clone for Grains {
    fn clone(&self) -> Grains {
        Grains { runs: self.runs.clone(), buffer: Mutex::default() }
    }
}

/// Stages in which tasks of a rank change a grain.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Touched {
    place: u32,
    /// Bit mask of the stages.
    stages: u32,
}

impl Ranks {
    /// Creates the ranks of a run whose contacts every rank has.
    pub fn new(messages: Arc<Timed>) -> Ranks {
        let (owners, sequence, work, turns) = Default::default();
        let (before, held, is_in_step, interventions) = Default::default();
        Ranks { messages, owners, sequence, work, before, held, turns, complete: true, is_in_step, interventions }
    }

    /// Returns the same ranks for a simulation that starts anew, with the contacts of all ranks.
    pub fn anew(&self) -> Ranks {
        Ranks { is_in_step: self.is_in_step, ..Ranks::new(self.messages.clone()) }
    }

    /// Returns true if the contacts are divided among the ranks.
    pub fn is_divided(&self) -> bool {
        !self.owners.is_empty()
    }

    /// Returns the number of this rank.
    pub fn own(&self) -> usize {
        self.messages.rank()
    }

    /// Returns the number of ranks.
    pub fn count(&self) -> usize {
        self.messages.ranks()
    }

    /// Returns the messages between the ranks.
    pub fn messages(&self) -> &Timed {
        &self.messages
    }

    /// Returns true if a box belongs to this rank.
    pub fn owns(&self, number: usize) -> bool {
        self.owner(number) == self.own()
    }

    /// Returns the rank of a box.
    pub fn owner(&self, number: usize) -> usize {
        usize::from(self.owners[number])
    }

    /// Divides the boxes among the ranks by recursive bisection, by the work of each in the last plan, or by the given number of grains
    /// if boxes have new numbers.
    pub fn divide(&mut self, boxes: &BoxGrid, grains: impl Fn(usize) -> usize) {
        let is_known = !boxes.follows() && self.work.len() == boxes.boxes();
        let known = if is_known { &self.work[..] } else { &[] };
        let work = |number: usize| known.get(number).map_or_else(|| grains(number), |&work| work as usize);
        let mut all: Vec<([i32; 3], usize)> =
            (0..boxes.boxes()).map(|number| (boxes.coordinates(number), number)).collect();
        self.owners.clear();
        self.owners.resize(all.len(), 0);
        let ranks = 0..self.count();
        bisect(&mut all, ranks, &work, &mut self.owners);
    }

    /// Takes up a new plan of this rank's tasks: finds the order of the tasks of all ranks and the way of each velocity from rank to rank.
    /// `bodies_of` calls a function for each body that a task of a stage changes, and `grains_of` returns the body indices of a box.
    pub fn link(
        &mut self,
        plan: &Plan,
        boxes: &BoxGrid,
        grains_of: impl Fn(usize) -> Range<usize>,
        bodies_of: impl Fn(usize, &PlannedTask, &mut dyn FnMut(u32)),
    ) {
        self.order_tasks(plan, boxes.boxes());
        // A grain in a box that has no neighbour of another rank is changed by its own rank alone.
        let grains = (0..boxes.boxes()).map(|number| grains_of(number).end).max().unwrap_or(0);
        let (mut is_near_border, mut holder) = (vec![false; grains], vec![0_u16; grains]);
        for number in 0..boxes.boxes() {
            let near = boxes.around(number).iter().flatten().any(|&beside| !self.owns(beside));
            is_near_border[grains_of(number)].fill(near);
            holder[grains_of(number)].fill(self.owners[number]);
        }
        let mut stages = vec![0_u16; grains];
        for stage in 0..STAGES {
            for task in plan.stage(stage) {
                bodies_of(stage, task, &mut |body| stages[body as usize] |= 1 << stage);
            }
        }
        for task in plan.stage(0) {
            bodies_of(DRIVEN_STAGE, task, &mut |body| stages[body as usize] |= 1 << DRIVEN_STAGE);
        }
        let touched = (0..grains).filter(|&place| stages[place] != 0 && is_near_border[place]);
        let touched: Vec<Touched> =
            touched.map(|place| Touched { place: place as u32, stages: stages[place].into() }).collect();
        // Place, stage and rank of each change, in this order.
        let mut changes: Vec<(u32, usize, usize)> = Vec::new();
        for (rank, bytes) in self.messages.gather(bytemuck::cast_slice(&touched)).iter().enumerate() {
            for Touched { place, stages } in records::<Touched>(bytes) {
                let of_rank = (0..=DRIVEN_STAGE).filter(|stage| stages >> stage & 1 == 1);
                changes.extend(of_rank.map(|stage| (place, stage, rank)));
            }
        }
        changes.sort_unstable();
        self.before = Default::default();
        for chain in changes.chunk_by(|one, next| one.0 == next.0) {
            let (place, _, last) = chain[chain.len() - 1];
            holder[place as usize] = last as u16;
            let mut from = last;
            for &(_, stage, to) in chain {
                if from != to {
                    self.before[stage].add(place, from, to, self.messages.rank());
                }
                from = to;
            }
        }
        self.held = vec![Grains::default(); self.count()];
        for (place, &rank) in (0..).zip(&holder) {
            self.held[usize::from(rank)].push(place);
        }
    }

    /// Finds the order of the tasks of all ranks.
    fn order_tasks(&mut self, plan: &Plan, boxes: usize) {
        let place =
            |(stage, task): (usize, &PlannedTask)| [(stage * boxes) as u32 + task.home, task.pairs.len() as u32];
        let stages = (0..STAGES).flat_map(|stage| plan.stage(stage).iter().map(move |task| (stage, task)));
        let own: Vec<[u32; 2]> = stages.map(place).collect();
        let mut all: Vec<([u32; 2], u16)> = Vec::new();
        for (rank, bytes) in (0..).zip(&self.messages.gather(bytemuck::cast_slice(&own))) {
            all.extend(records::<[u32; 2]>(bytes).map(|task| (task, rank)));
        }
        all.sort_unstable();
        self.sequence.clear();
        self.sequence.extend(all.iter().map(|&(_, rank)| rank));
        self.work.clear();
        self.work.resize(boxes, 0);
        all.iter().for_each(|([place, pairs], _)| self.work[*place as usize % boxes] += pairs);
    }

    /// Sends and receives the velocities of the grains that tasks of a stage change, before this stage.
    pub fn pass_on<T: Pod>(&self, stage: usize, bodies: TaskSlots<'_, T>) {
        let Links { sent, received } = &self.before[stage];
        if !sent.is_empty() || !received.is_empty() {
            let packed: Vec<_> = sent.iter().map(|(rank, grains)| (*rank, grains.pack(bodies))).collect();
            let sent: Vec<(usize, &[u8])> = packed.iter().map(|(rank, bytes)| (*rank, &bytes[..])).collect();
            self.exchange(&sent, received.iter().map(|(rank, grains)| (*rank, grains)), bodies);
        }
    }

    /// Sends the velocities of the grains to all ranks, each by the rank that has changed it last.
    pub fn share<T: Pod>(&self, bodies: TaskSlots<'_, T>) {
        let others = self.held.iter().enumerate().filter(|&(rank, _)| rank != self.own());
        let packed = self.held[self.own()].pack(bodies);
        let sent: Vec<(usize, &[u8])> = others.clone().map(|(rank, _)| (rank, &packed[..])).collect();
        self.exchange(&sent, others, bodies);
    }

    /// Sends packed velocities, and receives those of other grains, by rank.
    fn exchange<'a, T: Pod>(
        &self,
        sent: &[(usize, &[u8])],
        received: impl Iterator<Item = (usize, &'a Grains)> + Clone,
        bodies: TaskSlots<'_, T>,
    ) {
        let mut room: Vec<_> = received.clone().map(|(rank, grains)| (rank, grains.room(moving::<T>()))).collect();
        let mut parcels: Vec<_> = room.iter_mut().map(|(rank, bytes)| (*rank, &mut bytes[..])).collect();
        self.messages.exchange(sent, &mut parcels);
        for ((_, grains), (_, bytes)) in received.zip(&parcels) {
            grains.unpack(bodies, bytes);
        }
    }

    /// Returns one record per task of the whole plan, in its order, given those of this rank's tasks.
    pub fn in_order<T: Pod>(&self, own: &[T]) -> Vec<T> {
        let all = self.messages.gather(bytemuck::must_cast_slice(own));
        let mut of_ranks: Vec<_> = all.iter().map(|bytes| bytes.chunks_exact(size_of::<T>())).collect();
        let next =
            |&rank: &u16| bytemuck::pod_read_unaligned(of_ranks[usize::from(rank)].next().expect("a record per task"));
        self.sequence.iter().map(next).collect()
    }

    /// Returns the items of all tasks of the whole plan, in its order, given those of each of this rank's tasks.
    pub fn merge<T: Serialize + DeserializeOwned>(&self, own: Vec<Vec<T>>) -> Vec<Vec<T>> {
        let all = self.everyone(&own).into_iter();
        let mut of_ranks: Vec<_> = all.map(Vec::into_iter).collect();
        let next = |&rank: &u16| of_ranks[usize::from(rank)].next().expect("a list per task");
        self.sequence.iter().map(next).collect()
    }

    /// Returns the values of all ranks, in their order.
    pub fn everyone<T: Serialize + DeserializeOwned>(&self, own: &T) -> Vec<T> {
        let bytes = postcard::to_stdvec(own).expect("plain data");
        let all = self.messages.gather(&bytes);
        all.iter().map(|bytes| postcard::from_bytes(bytes).expect("ranks run the same program")).collect()
    }

    /// Sets the turns of the ranks with dynamic walls, given the numbers of this rank's tasks with such contacts and of these contacts.
    pub fn take_turns(&mut self, own: Vec<(u32, usize)>) {
        let all = self.everyone(&own).into_iter().enumerate();
        let mut tasks: Vec<(u32, usize, usize)> =
            all.flat_map(|(rank, tasks)| tasks.into_iter().map(move |(task, count)| (task, rank, count))).collect();
        tasks.sort_unstable();
        self.turns.clear();
        for (_, rank, count) in tasks {
            match self.turns.last_mut() {
                Some(last) if last.0 == rank => last.1 += count,
                _ => self.turns.push((rank, count)),
            }
        }
    }

    /// Lets the ranks with dynamic walls act in turn on a common state: `act` relaxes the next contacts of this rank, given their range in
    /// its list, and changes the state of all ranks.
    pub fn in_turn<T: Serialize + DeserializeOwned>(&self, state: &mut T, mut act: impl FnMut(Range<usize>, &mut T)) {
        let mut next = 0;
        for &(rank, count) in &self.turns {
            let mut bytes = Vec::new();
            if rank == self.own() {
                act(next..next + count, state);
                next += count;
                bytes = postcard::to_stdvec(state).expect("plain data");
            }
            self.messages.broadcast(&mut bytes, rank);
            *state = postcard::from_bytes(&bytes).expect("ranks run the same program");
        }
    }

    /// Returns true if a condition holds on some rank.
    pub fn any(&self, own: bool) -> bool {
        self.messages.gather(&[u8::from(own)]).iter().any(|bytes| bytes[0] != 0)
    }

    /// Returns the sum of a number over the ranks.
    pub fn sum(&self, own: usize) -> usize {
        self.everyone(&own).iter().sum()
    }

    /// Sends lists of records to the ranks, one list for each, and returns the received ones in the order of the ranks.
    pub fn trade<T: Pod>(&self, lists: &[Vec<T>]) -> Vec<T> {
        let (own, lengths) = (self.own(), lists.iter().map(Vec::len).collect::<Vec<_>>());
        let others = || (0..self.count()).filter(move |&rank| rank != own);
        let all = self.everyone(&lengths);
        let sent: Vec<(usize, &[u8])> =
            others().map(|rank| (rank, bytemuck::must_cast_slice(&lists[rank][..]))).collect();
        let mut received: Vec<Vec<u8>> = others().map(|rank| vec![0; all[rank][own] * size_of::<T>()]).collect();
        let mut parcels: Vec<_> = others().zip(received.iter_mut().map(|bytes| &mut bytes[..])).collect();
        self.messages.exchange(&sent, &mut parcels);
        received.iter().flat_map(|bytes| records::<T>(bytes)).collect()
    }
}

impl Links {
    /// Adds a grain that goes from one rank to another, if one of them is this rank.
    fn add(&mut self, place: u32, from: usize, to: usize, own: usize) {
        let (list, other) = match (from == own, to == own) {
            (true, _) => (&mut self.sent, to),
            (_, true) => (&mut self.received, from),
            _ => return,
        };
        let known = list.iter().position(|(rank, _)| *rank == other).unwrap_or_else(|| {
            list.push((other, Grains::default()));
            list.len() - 1
        });
        list[known].1.push(place);
    }
}

impl Grains {
    /// Appends a grain after all others.
    fn push(&mut self, place: u32) {
        match self.runs.last_mut() {
            Some(run) if run.end == place => run.end += 1,
            _ => self.runs.push(place..place + 1),
        }
    }

    fn places(&self) -> impl Iterator<Item = u32> + '_ {
        self.runs.iter().cloned().flatten()
    }

    /// Returns the buffer with room for so many bytes of each grain.
    fn room(&self, bytes: usize) -> MutexGuard<'_, Vec<u8>> {
        let mut buffer = self.buffer.lock().expect("nothing panics while it holds the lock");
        buffer.resize(self.runs.iter().map(Range::len).sum::<usize>() * bytes, 0);
        buffer
    }

    /// Writes the velocities and spins of the grains into the buffer.
    fn pack<T: Pod>(&self, bodies: TaskSlots<'_, T>) -> MutexGuard<'_, Vec<u8>> {
        let (mut buffer, number) = (self.room(moving::<T>()), size_of::<T>() / 8);
        for (place, moving) in self.places().zip(buffer.chunks_exact_mut(moving::<T>())) {
            let body = bodies.get(place);
            let bytes = bytemuck::bytes_of(&body);
            moving[..3 * number].copy_from_slice(&bytes[..3 * number]);
            moving[3 * number..].copy_from_slice(&bytes[4 * number..7 * number]);
        }
        buffer
    }

    /// Sets the velocities and spins of the grains.
    fn unpack<T: Pod>(&self, bodies: TaskSlots<'_, T>, bytes: &[u8]) {
        let number = size_of::<T>() / 8;
        for (place, moving) in self.places().zip(bytes.chunks_exact(moving::<T>())) {
            let mut body = bodies.get(place);
            let bytes = bytemuck::bytes_of_mut(&mut body);
            bytes[..3 * number].copy_from_slice(&moving[..3 * number]);
            bytes[4 * number..7 * number].copy_from_slice(&moving[3 * number..]);
            bodies.set(place, body);
        }
    }
}

/// Returns the bytes of velocity and spin of a body: of its eight numbers, all but the inverse mass and the inverse radius.
const fn moving<T>() -> usize {
    size_of::<T>() / 8 * 6
}

/// Reads records from bytes.
fn records<T: Pod>(bytes: &[u8]) -> impl Iterator<Item = T> {
    bytes.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned)
}

/// Divides boxes, by their coordinates and numbers, among ranks in proportion to their work, across the axis with the least work at the cut.
fn bisect(boxes: &mut [([i32; 3], usize)], ranks: Range<usize>, work: &impl Fn(usize) -> usize, owners: &mut [u16]) {
    if ranks.len() <= 1 {
        boxes.iter().for_each(|&(_, number)| owners[number] = ranks.start as u16);
        return;
    }
    // An empty box costs little, but not nothing.
    let weight = |&(_, number): &([i32; 3], usize)| 8 * work(number) + 1;
    let all: usize = boxes.iter().map(weight).sum();
    let middle = ranks.start + ranks.len() / 2;
    let share = all * (middle - ranks.start) / ranks.len();
    // Work along the cut across an axis, and place of the cut.
    let mut cut_across = |axis: usize| {
        boxes.sort_unstable_by_key(|&(at, _)| (at[axis], at));
        let mut sum = 0;
        let is_low = |one: &&([i32; 3], usize)| {
            sum += weight(one);
            2 * sum <= 2 * share + weight(one)
        };
        let cut = boxes.iter().take_while(is_low).count();
        let layer = boxes.get(cut).map_or(0, |(at, _)| at[axis]);
        (boxes.iter().filter(|(at, _)| at[axis] == layer).map(weight).sum::<usize>(), cut)
    };
    let axis = (0..3).min_by_key(|&axis| cut_across(axis).0).unwrap_or(0);
    let (_, cut) = cut_across(axis);
    let (low, high) = boxes.split_at_mut(cut);
    bisect(low, ranks.start..middle, work, owners);
    bisect(high, middle..ranks.end, work, owners);
}
