//! Runs on several ranks: one leads, the others follow.
//!
//! The leading rank holds the simulation that its caller sees. The caller divides it, and from then on it asks the others to make the calls
//! that need contacts of all ranks: steps, and the contacts, energies and checkpoints between them. All ranks hold all grains, so that
//! whatever needs only these stays on the leading rank. A follower answers until the leading rank ends.

use super::checkpoint::state::State;
use super::{Request, Simulation};
use crate::SettingError;
use crate::messages::{Messages, Timed};
use crate::partition::Ranks;
use crate::scene::{Scene, SolverMethod, SolverSettings, Stop};
use crate::schedule::Scheduler;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Simulation for the followers.
#[derive(Serialize, Deserialize)]
struct Division {
    scene: String,
    checkpoint: Vec<u8>,
    settings: String,
    scheduler: Scheduler,
    threads: usize,
}

/// Answers the requests of the leading rank, until it ends the run; returns at once on the leading rank, which is rank 0.
pub fn follow(messages: &Arc<dyn Messages>) {
    let mut simulation: Option<Simulation> = None;
    while messages.rank() > 0 {
        let request = Request::take(&**messages);
        match (request, &mut simulation) {
            (Request::End, _) => return,
            (Request::Divide, simulation) => *simulation = Some(Division::take_up(messages)),
            (request, Some(simulation)) => simulation.answer(request),
            (_, None) => unreachable!("the leading rank divides a simulation first"),
        }
    }
}

/// Ends the followers, on the leading rank.
pub fn dismiss(messages: &Arc<dyn Messages>) {
    Request::End.send(&**messages);
}

impl Request {
    fn send(self, messages: &dyn Messages) {
        if messages.rank() == 0 {
            messages.broadcast(&mut vec![self as u8], 0);
        }
    }

    fn take(messages: &dyn Messages) -> Request {
        let mut bytes = Vec::new();
        messages.broadcast(&mut bytes, 0);
        let sent = Request::ALL.into_iter().find(|request| bytes == [*request as u8]);
        sent.expect("ranks run the same program")
    }
}

impl Simulation {
    /// Divides the contacts of this simulation of a scene among ranks, on the leading rank; the others [`follow`]. The bits stay the same.
    /// Later changes of settings and interventions of the caller are not possible.
    ///
    /// # Errors
    /// [`SettingError::Ranks`] for what only one rank can do: another method than Gauss-Seidel, a budget of wall time, and a ledger.
    pub fn divide_among(&mut self, scene: &Scene, messages: &Arc<dyn Messages>) -> Result<(), SettingError> {
        let refused = match &self.settings {
            _ if self.ledger.is_some() => Some("an energy ledger"),
            SolverSettings { stop: Stop::TimeBudget { .. }, .. } => Some("a budget of wall time (solver.stop)"),
            SolverSettings { method: SolverMethod::GaussSeidel, .. } => None,
            _ => Some("a method other than Gauss-Seidel (solver.method)"),
        };
        if let Some(what) = refused {
            return Err(SettingError::Ranks { what });
        }
        Request::Divide.send(&**messages);
        let scene = self.stages.as_ref().map_or(scene, |stages| &stages.scene);
        let division = Division {
            // The step that an accuracy asks for is chosen.
            scene: toml::to_string(&Scene { accuracy: None, ..scene.clone() })
                .expect("a scene is made of plain tables"),
            checkpoint: self.checkpoint(),
            settings: toml::to_string(&self.settings).expect("settings are a plain table"),
            scheduler: self.team.scheduler(),
            threads: self.team.threads(),
        };
        messages.broadcast(&mut postcard::to_stdvec(&division).expect("plain data"), 0);
        self.join(messages);
        Ok(())
    }

    /// Divides the contacts among the ranks, each of which has all of them.
    fn join(&mut self, messages: &Arc<dyn Messages>) {
        let mut ranks = Ranks::new(Arc::new(Timed::new(messages.clone())));
        ranks.interventions = self.interventions.count;
        self.layout.ranks = Some(ranks);
        self.candidates.divide(&mut self.layout, &self.world);
    }

    /// Wall time of the messages between ranks so far, with the wait for other ranks, s; a part of the times of the phases.
    pub fn exchange_seconds(&self) -> f64 {
        self.layout.ranks.as_ref().map_or(0.0, |ranks| ranks.messages().seconds())
    }

    /// Makes the call of the leading rank.
    fn answer(&mut self, request: Request) {
        match request {
            Request::Step => drop(self.step()),
            Request::PairContacts => drop(self.pair_contacts()),
            Request::WallContacts => self.for_each_wall_contact(|_| ()),
            Request::Energy => drop(self.contact_energy()),
            Request::Checkpoint => drop(State::of(self)),
            Request::End | Request::Divide => unreachable!("these concern all simulations"),
        }
    }

    /// Begins a step on all ranks.
    pub(super) fn begin_step_of_ranks(&mut self) {
        let Some(ranks) = &mut self.layout.ranks else { return };
        let intervened = self.interventions.any_since(ranks.interventions);
        assert!(!intervened, "a simulation on several ranks takes no interventions of its caller");
        Request::Step.send(ranks.messages());
        ranks.is_in_step = true;
    }

    /// Ends a step on all ranks.
    pub(super) fn end_step_of_ranks(&mut self) {
        let Some(ranks) = &mut self.layout.ranks else { return };
        // A stage that starts the simulation anew counts, too.
        (ranks.is_in_step, ranks.interventions) = (false, self.interventions.count);
    }

    /// Returns the ranks, if the contacts are divided among them; between steps, the leading rank asks the others for the same call.
    pub(crate) fn together(&self, request: Request) -> Option<&Ranks> {
        let ranks = self.layout.ranks.as_ref().filter(|ranks| ranks.is_divided())?;
        if !ranks.is_in_step {
            request.send(ranks.messages());
        }
        Some(ranks)
    }
}

impl Division {
    /// Takes up the simulation of the leading rank.
    fn take_up(messages: &Arc<dyn Messages>) -> Simulation {
        let mut bytes = Vec::new();
        messages.broadcast(&mut bytes, 0);
        let division: Division = postcard::from_bytes(&bytes).expect("ranks run the same program");
        let scene = Scene::parse(&division.scene).expect("the leading rank has checked the scene");
        let mut simulation = Simulation::resume(&scene, &division.checkpoint).expect("the state of the leading rank");
        simulation.settings = toml::from_str(&division.settings).expect("the settings of the leading rank");
        simulation.use_team(division.scheduler, division.threads).unwrap_or_else(|error| panic!("{error}"));
        simulation.join(messages);
        simulation
    }
}
