//! One queue for all threads, behind a lock: the initial version of Rönnbäck's thesis.

use std::sync::Mutex;

/// Numbers of tasks that are still to be done.
#[derive(Debug)]
pub struct CentralQueue {
    next: Mutex<usize>,
    count: usize,
}

impl CentralQueue {
    /// A queue of the tasks below `count`.
    pub fn new(count: usize) -> CentralQueue {
        CentralQueue { next: Mutex::new(0), count }
    }

    /// Takes the next task; `None` when all are taken.
    pub fn pop(&self) -> Option<usize> {
        let mut next = self.next.lock().expect("nothing panics while it holds the lock");
        let task = *next;
        (task < self.count).then(|| {
            *next += 1;
            task
        })
    }

    /// Takes tasks and does them until none is left.
    pub fn drain(&self, task: &impl Fn(usize)) {
        while let Some(number) = self.pop() {
            task(number);
        }
    }
}
