//! What a position is called: work offset, position register and tool offset over the machine position, mm.

/// Offsets in force. machine = program + work + register + tool.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Work offsets, from 1; index 0 is not used.
    pub work: [[f64; 3]; 10],
    /// The one in force.
    pub active: usize,
    /// Offset made by setting the position register.
    pub register: [f64; 3],
    /// A register offset put aside.
    pub set_aside: [f64; 3],
    /// Tool length offset.
    pub tool: [f64; 3],
}

impl Frame {
    /// No offsets.
    pub const fn new() -> Self {
        Self {
            work: [[0.0; 3]; 10],
            active: 1,
            register: [0.0; 3],
            set_aside: [0.0; 3],
            tool: [0.0; 3],
        }
    }

    /// Machine position minus program position along an axis.
    pub fn total(&self, axis: usize) -> f64 {
        let work = self
            .work
            .get(self.active)
            .map_or(0.0, |offsets| offsets[axis]);
        work + self.register[axis] + self.tool[axis]
    }

    /// All three axes.
    pub fn totals(&self) -> [f64; 3] {
        [self.total(0), self.total(1), self.total(2)]
    }
}
