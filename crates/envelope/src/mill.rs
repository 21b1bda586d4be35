//! A milling cutter along a polyline in space: where rays out of the material meet what it passed over.

use crate::boxes::{Boxes, RUN};
use crate::ring::{End, Piece};
use crate::space::{dot, length, minus, Point3};

/// A cutter's end swept along a polyline of its centre: a ball, or a ring of balls and what it encloses.
#[derive(Clone, Debug)]
pub struct EndSweep {
    nodes: Vec<Point3>,
    /// Out of the material, at every node, or one for all.
    axes: Vec<Point3>,
    end: End,
    boxes: Boxes,
    /// Of every run of the lowest level: how far nodes leave its chord, and axes the first of them.
    spread: Vec<[f64; 2]>,
}

impl EndSweep {
    /// The sweep; nodes must be finite numbers, axes unit vectors, one for all or one a node.
    pub fn new(nodes: Vec<Point3>, axes: Vec<Point3>, end: End) -> Self {
        let boxes = Boxes::over(&nodes);
        let mut sweep = Self {
            nodes,
            axes,
            end,
            boxes,
            spread: Vec::new(),
        };
        if end.ring > 0.0 {
            sweep.spread = (0..sweep.boxes.runs())
                .map(|run| sweep.spread_of(run))
                .collect();
        }
        sweep
    }

    /// How far the nodes of a run leave its chord, and its axes the first.
    fn spread_of(&self, run: usize) -> [f64; 2] {
        let Some(chord) = self.chord(run, [0.0; 3]) else {
            return [0.0; 2];
        };
        let nodes = self.nodes.iter().enumerate().skip(run * RUN).take(RUN + 1);
        nodes.fold([0.0; 2], |[aside, turned]: [f64; 2], (k, node)| {
            let turn = minus(self.axis(k), chord.axes[0]);
            [aside.max(chord.off(*node).sqrt()), turned.max(length(turn))]
        })
    }

    /// Where each ray, coming out of the material, first meets the swept region: between −reach and what is known.
    ///
    /// A ray is an origin and a unit vector, and where it is known to meet something else. An end whose centre lies
    /// below −reach on the ray is not seen.
    pub fn entries(
        &self,
        rays: impl Iterator<Item = (Point3, Point3, f64)>,
        reach: f64,
    ) -> Vec<f64> {
        let mut runs = Vec::new();
        rays.map(|(origin, direction, known)| {
            let best = if self.end.ring > 0.0 {
                self.ring(origin, direction, [reach, known], &mut runs)
            } else {
                self.over_runs(origin, direction, [reach, known], |run, best| {
                    best.min(self.balls(run, origin, direction, reach))
                })
            };
            best.max(-reach)
        })
        .collect()
    }

    /// What becomes of what is known when all runs are worked off that an end may come lower in.
    fn over_runs(
        &self,
        origin: Point3,
        direction: Point3,
        [reach, known]: [f64; 2],
        mut work: impl FnMut(usize, f64) -> f64,
    ) -> f64 {
        let mut best = known;
        let mut stack = vec![(self.boxes.top(), 0_usize)];
        while let Some((level, index)) = stack.pop() {
            let Some(found) = self.boxes.get(level, index) else {
                continue;
            };
            if found.lowest(origin, direction, self.end.reach(), reach) >= best {
                continue;
            }
            if level == 0 {
                best = work(index, best);
            } else {
                stack.push((level - 1, 2 * index));
                stack.push((level - 1, 2 * index + 1));
            }
        }
        best
    }

    /// A ring's entry: the run that would touch is asked first, so that hardly any other can come lower.
    fn ring(
        &self,
        origin: Point3,
        direction: Point3,
        [reach, known]: [f64; 2],
        runs: &mut Vec<(usize, Piece)>,
    ) -> f64 {
        runs.clear();
        self.over_runs(origin, direction, [reach, known], |run, best| {
            runs.extend(self.run(run, origin).map(|piece| (run, piece)));
            best
        });
        let Some((_, any)) = runs.first() else {
            return known;
        };
        let touching = self.end.touching(direction, any.axes[0]);
        let nearest = |a: &&(usize, Piece), b: &&(usize, Piece)| {
            a.1.off(touching).total_cmp(&b.1.off(touching))
        };
        let first = runs.iter().min_by(nearest);
        let mut best = known;
        for (run, all) in first.into_iter().chain(runs.iter()) {
            if self.end.lowest(all, direction, touching) >= best {
                continue;
            }
            for piece in self.pieces(*run, origin) {
                let low = self.end.lowest(&piece, direction, touching).max(-reach);
                if low < best && piece.ahead(direction) > -reach {
                    best = best.min(self.end.entry(&piece, direction, [low, best]));
                }
            }
        }
        best
    }

    /// All pieces of a run together, given from a ray's origin.
    fn run(&self, run: usize, origin: Point3) -> Option<Piece> {
        let [aside, turned] = *self.spread.get(run)?;
        self.chord(run, origin).map(|chord| Piece {
            aside,
            turned,
            ..chord
        })
    }

    fn chord(&self, run: usize, origin: Point3) -> Option<Piece> {
        let last = (run * RUN + RUN).min(self.nodes.len().saturating_sub(1));
        let nodes = self.nodes.get(run * RUN..=last)?;
        Piece::over(nodes, [self.axis(run * RUN), self.axis(last)], origin)
    }

    /// The pieces of a run, one by one; a single node is a piece without length.
    fn pieces(&self, run: usize, origin: Point3) -> impl Iterator<Item = Piece> + '_ {
        let first = run * RUN;
        let last = (first + RUN)
            .min(self.nodes.len().saturating_sub(1))
            .max(first + 1);
        (first..last).filter_map(move |k| {
            let nodes = self.nodes.get(k..(k + 2).min(self.nodes.len()))?;
            Piece::over(nodes, [self.axis(k), self.axis(k + 1)], origin)
        })
    }

    fn axis(&self, node: usize) -> Point3 {
        let one = self.axes.get(node).or_else(|| self.axes.first());
        one.copied().unwrap_or([0.0, 0.0, 1.0])
    }

    fn balls(&self, run: usize, origin: Point3, direction: Point3, reach: f64) -> f64 {
        let nodes = self.nodes.get(run * RUN..).unwrap_or_default();
        let mut best = f64::INFINITY;
        for node in nodes.iter().take(RUN + 1) {
            best = best.min(self.ball(minus(*node, origin), direction, reach));
        }
        for pair in nodes.windows(2).take(RUN) {
            if let [a, b] = pair {
                let (from, segment) = (minus(*a, origin), minus(*b, *a));
                best = best.min(self.tube(from, segment, direction, reach));
            }
        }
        best
    }

    fn ball(&self, from: Point3, direction: Point3, reach: f64) -> f64 {
        let along = dot(from, direction);
        let square = self.end.corner.powi(2) - (dot(from, from) - along * along);
        if along <= -reach || square <= 0.0 {
            return f64::INFINITY;
        }
        along - square.sqrt()
    }

    /// Where the ray enters the cylinder around a segment, between the segment's ends.
    fn tube(&self, from: Point3, segment: Point3, direction: Point3, reach: f64) -> f64 {
        let (length, with, start) = (
            dot(segment, segment),
            dot(segment, direction),
            dot(segment, from),
        );
        // |t·d − from|² less its part along the segment is R²: a t² − 2 b t + c = 0.
        let a = length - with * with;
        let b = length * dot(from, direction) - with * start;
        let c = length * (dot(from, from) - self.end.corner.powi(2)) - start * start;
        let square = b * b - a * c;
        if a <= 1e-15 * length || square <= 0.0 {
            return f64::INFINITY;
        }
        let t = (b - square.sqrt()) / a;
        let share = (t * with - start) / length;
        let centre = dot(from, direction) + share.clamp(0.0, 1.0) * with;
        if !(0.0..=1.0).contains(&share) || centre <= -reach {
            return f64::INFINITY;
        }
        t
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UP: Point3 = [0.0, 0.0, 1.0];

    fn along_x(ring: f64, corner: f64) -> EndSweep {
        let nodes = vec![[0.0, 0.0, corner], [50.0, 0.0, corner]];
        EndSweep::new(nodes, vec![UP], End::new(ring, corner))
    }

    #[test]
    fn a_ring_leaves_a_flat_with_round_sides() {
        for corner in [0.0, 1.0] {
            let sweep = along_x(2.0, corner);
            let rays = (0..12).map(|k| ([20.0, 0.25 * k as f64, 0.0], UP, 5.0));
            for (k, height) in sweep.entries(rays, 5.0).into_iter().enumerate() {
                let over = (0.25 * k as f64 - 2.0).max(0.0);
                let wanted = if over > corner {
                    5.0
                } else {
                    corner - (corner * corner - over * over).sqrt()
                };
                assert!((height - wanted).abs() < 1e-10, "{corner} {k} {height}");
            }
        }
    }

    #[test]
    fn a_ring_of_none_is_a_ball() {
        let nodes: Vec<Point3> = (0..40)
            .map(|k| {
                [
                    0.7 * k as f64,
                    (0.3 * k as f64).sin(),
                    3.0 + 0.2 * (0.5 * k as f64).cos(),
                ]
            })
            .collect();
        let tilted = [0.6, 0.0, 0.8];
        let (ball, ring) = (
            EndSweep::new(nodes.clone(), vec![UP], End::new(0.0, 3.0)),
            EndSweep::new(nodes, vec![tilted], End::new(1e-13, 3.0)),
        );
        let rays = || (0..60).map(|k| ([0.4 * k as f64, 0.02 * k as f64, 0.0], tilted, 5.0));
        for (a, b) in ball
            .entries(rays(), 5.0)
            .into_iter()
            .zip(ring.entries(rays(), 5.0))
        {
            assert!((a - b).abs() < 1e-9, "{a} {b}");
        }
    }

    #[test]
    fn a_straight_pass_leaves_a_round_groove() {
        let sweep = along_x(0.0, 3.0);
        let rays = (0..20).map(|k| ([5.0 + k as f64, 0.1 * k as f64, 0.0], [0.0, 0.0, 1.0], 5.0));
        for (k, height) in sweep.entries(rays, 5.0).into_iter().enumerate() {
            let y = 0.1 * k as f64;
            assert!((height - (3.0 - (9.0 - y * y).sqrt())).abs() < 1e-12);
        }
    }

    #[test]
    fn beyond_its_end_it_leaves_its_own_ball() {
        let sweep = along_x(0.0, 3.0);
        let rays = [([51.0, 1.0, 0.0], UP, 5.0), ([90.0, 0.0, 0.0], UP, 5.0)];
        let found = sweep.entries(rays.into_iter(), 5.0);
        assert!((found[0] - (3.0 - 7.0_f64.sqrt())).abs() < 1e-12);
        assert_eq!(found[1], 5.0);
    }
}
