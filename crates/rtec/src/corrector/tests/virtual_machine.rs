//! Commands as a planner gives them, and random numbers that are the same in every run.

/// A generator after Marsaglia's xorshift.
pub(super) struct Dice(u64);

impl Dice {
    pub(super) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    /// In [low, high).
    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// One of `count`.
    pub(super) fn of(&mut self, count: usize) -> usize {
        (self.between(0.0, 1.0) * count as f64) as usize
    }

    pub(super) fn once_in(&mut self, count: usize) -> bool {
        self.of(count) == 0
    }
}

/// One axis of a planner: it goes to its target with limited speed and acceleration, and comes to rest there.
#[derive(Clone, Copy)]
pub(super) struct Planner {
    pub(super) position: f64,
    pub(super) velocity: f64,
    pub(super) target: f64,
    pub(super) speed: f64,
    pub(super) acceleration: f64,
}

impl Planner {
    pub(super) fn at(position: f64, acceleration: f64) -> Self {
        Self {
            position,
            velocity: 0.0,
            target: position,
            speed: 0.0,
            acceleration,
        }
    }

    pub(super) fn step(&mut self, period: f64) -> f64 {
        let way = self.target - self.position;
        let change = self.acceleration * period;
        // The speed from which it can brake over what is left after this period.
        let softly = 0.8 * change;
        let brake = ((softly * softly + 8.0 * softly / period * way.abs()).sqrt() - softly) / 2.0;
        let along = self.velocity * way.signum();
        let fast = (along + change).min(self.speed.max(along - change));
        self.velocity = way.signum() * fast.min(brake).min(way.abs() / period);
        self.position += self.velocity * period;
        if way.abs() < 1e-9 && self.velocity.abs() <= change {
            (self.position, self.velocity) = (self.target, 0.0);
        }
        self.position
    }

    /// Whether it can go to a new target without turning round, and stop there.
    pub(super) fn reaches(&self, target: f64) -> bool {
        let way = target - self.position;
        let braking = self.velocity * self.velocity / (2.0 * self.acceleration);
        self.velocity * way >= 0.0 && way.abs() > braking + self.velocity.abs() * 2e-3
    }
}
