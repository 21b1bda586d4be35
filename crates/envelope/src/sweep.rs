//! The region a nose passes over, and where rays out of the material meet it.

use crate::bundle::{Bundle, Runs, Waiting, BUNDLE};
use crate::nose::{Disc, Nose};
use crate::ray::{Point, Ray};
use crate::tree::{Tree, RUN};

/// A nose swept along a polyline of its centre.
#[derive(Clone, Debug)]
pub struct Sweep {
    nodes: Vec<Point>,
    /// Contact of each segment's two sides, from the centre: surface normal to the left of travel, and to the right.
    contacts: Vec<[Point; 2]>,
    nose: Nose,
    tree: Tree,
}

/// A ray and its angle (0 where the nose is round and none matters), the disc that holds the nose as seen along it, and
/// how far down it is looked.
struct Asked {
    ray: Ray,
    angle: f64,
    disc: Disc,
    floor: f64,
}

/// The lowest meeting so far, and the run of segments it was found in.
#[derive(Clone, Copy, Default)]
struct Found {
    along: f64,
    run: usize,
}

impl Asked {
    /// Below what the nose does not reach on the ray, standing there; infinite where it passes beside or is not seen.
    fn low(&self, (along, over): (f64, f64)) -> f64 {
        let beside = over - self.disc.beside;
        let square = self.disc.radius * self.disc.radius - beside * beside;
        if square > 0.0 && along > self.floor {
            along - self.disc.above - square.sqrt()
        } else {
            f64::INFINITY
        }
    }
}

impl Asked {
    /// The lower of that and `best`: the root is taken only where it says something.
    fn lower(&self, (along, over): (f64, f64), best: f64) -> f64 {
        let beside = over - self.disc.beside;
        let square = self.disc.radius * self.disc.radius - beside * beside;
        let (from, above) = (along - self.disc.above, along - self.disc.above - best);
        if square > 0.0 && along > self.floor && (above < 0.0 || above * above < square) {
            best.min(from - square.sqrt())
        } else {
            best
        }
    }
}

impl Sweep {
    /// The sweep; one node is a nose that stands still, none sweeps nothing. Nodes must be finite numbers.
    pub fn new(nodes: Vec<Point>, nose: Nose) -> Self {
        let contacts = nodes
            .windows(2)
            .map(|pair| match *pair {
                [a, b] => contacts_of(a, b, &nose),
                _ => [[0.0; 2]; 2],
            })
            .collect();
        let tree = Tree::over(&nodes);
        Self {
            nodes,
            contacts,
            nose,
            tree,
        }
    }

    /// Where each ray, coming out of the material, first meets the swept region: between −reach and what is `known`.
    ///
    /// `known` where it meets nothing lower. A nose whose centre lies below −reach on the ray is not seen.
    pub fn entries(&self, rays: impl Iterator<Item = (Ray, f64)>, reach: f64) -> Vec<f64> {
        let mut entries = Vec::with_capacity(rays.size_hint().0);
        let (mut bundled, mut near) = (Vec::with_capacity(BUNDLE), 0);
        for (ray, known) in rays {
            bundled.push((self.asked(ray, -reach), known));
            if bundled.len() == BUNDLE {
                self.enter(&bundled, &mut near, &mut entries);
                bundled.clear();
            }
        }
        self.enter(&bundled, &mut near, &mut entries);
        entries
    }

    fn asked(&self, ray: Ray, floor: f64) -> Asked {
        let angle = if self.nose.is_round() {
            0.0
        } else {
            ray.angle()
        };
        Asked {
            ray,
            angle,
            disc: self.nose.disc(angle),
            floor,
        }
    }

    /// The entries of some rays: neighbours share what they look at, where it is little.
    fn enter(&self, rays: &[(Asked, f64)], near: &mut usize, entries: &mut Vec<f64>) {
        let mut found = [Found::default(); BUNDLE];
        let mut worst = f64::NEG_INFINITY;
        for (found, (asked, known)) in found.iter_mut().zip(rays) {
            *near = self.nearer(asked, *near);
            *found = Found {
                along: *known,
                run: *near / RUN,
            };
            // As far as a round nose reaches a worn one need not.
            if let (true, Some(node)) = (self.nose.is_round(), self.nodes.get(*near)) {
                found.along = asked.lower(asked.ray.of(*node), *known);
            }
            worst = worst.max(found.along);
        }
        let shared = self.shared(rays, worst).filter(|_| self.nose.is_round());
        for (found, (asked, _)) in found.iter_mut().zip(rays) {
            let run = found.run;
            self.look_at(asked, run, found);
            match shared.as_ref() {
                Some(runs) => self.look_at_those(asked, runs.as_slice(), run, found),
                None => *found = self.entry(asked, *found),
            }
            entries.push(found.along.max(asked.floor));
            if !self.nose.is_round() {
                *near = found.run * RUN;
            }
        }
    }

    /// The node that passes the ray closer than its neighbours, from one on along the path: where to look first.
    fn nearer(&self, asked: &Asked, from: usize) -> usize {
        let beside = |node: usize| self.nodes.get(node).map(|node| asked.ray.of(*node).1.abs());
        let (mut near, Some(mut least)) = (from, beside(from)) else {
            return from;
        };
        for forward in [true, false] {
            while let Some(next) = if forward {
                near.checked_add(1)
            } else {
                near.checked_sub(1)
            } {
                match beside(next) {
                    Some(closer) if closer < least => (near, least) = (next, closer),
                    _ => break,
                }
            }
        }
        near
    }

    /// The runs that may reach below `worst` on any of the rays; none where there are many, or the rays differ.
    fn shared(&self, rays: &[(Asked, f64)], worst: f64) -> Option<Runs> {
        let bundle = Bundle::of(rays.iter().map(|(asked, _)| (&asked.ray, &asked.disc)))?;
        let floor = rays.first()?.0.floor;
        let (mut runs, mut waiting) = (Runs::default(), Waiting::of(self.tree.top()));
        while let Some((level, index)) = waiting.next() {
            let Some(around) = self.tree.get(level, index) else {
                continue;
            };
            let low = around.lowest_of_bundle(&bundle, floor, worst);
            if low >= worst {
                continue;
            }
            if level > 0 {
                waiting.halves(level, index);
            } else if !runs.push((index, low)) {
                return None;
            }
        }
        Some(runs)
    }

    /// Looks at those of some runs that reach below what was found; at `seen` it has looked.
    fn look_at_those(&self, asked: &Asked, runs: &[(usize, f64)], seen: usize, found: &mut Found) {
        for (run, low) in runs {
            let below = *run != seen && *low < found.along;
            if below && self.lowest(asked, 0, *run, found) < found.along {
                self.look_at(asked, *run, found);
            }
        }
    }

    /// Neighbouring rays meet neighbouring segments: looking first where the last one was met, then from there up the
    /// tree at what stands beside, leaves little to look at.
    fn entry(&self, asked: &Asked, mut found: Found) -> Found {
        let mut index = found.run;
        for level in 0..self.tree.top() {
            if self.lowest(asked, level, index ^ 1, &found) < found.along {
                self.descend(asked, level, index ^ 1, &mut found);
            }
            index /= 2;
        }
        found
    }

    /// Looks at the segments in a box that reaches below what was found, the lower half first.
    fn descend(&self, asked: &Asked, level: usize, index: usize, found: &mut Found) {
        if level == 0 {
            return self.look_at(asked, index, found);
        }
        let mut halves = [2 * index, 2 * index + 1]
            .map(|half| (self.lowest(asked, level - 1, half, found), half));
        if halves[1].0 < halves[0].0 {
            halves.reverse();
        }
        for (low, half) in halves {
            if low < found.along {
                self.descend(asked, level - 1, half, found);
            }
        }
    }

    fn lowest(&self, asked: &Asked, level: usize, index: usize, found: &Found) -> f64 {
        self.tree.get(level, index).map_or(f64::INFINITY, |around| {
            around.lowest(&asked.ray, &asked.disc, asked.floor, found.along)
        })
    }

    fn look_at(&self, asked: &Asked, run: usize, found: &mut Found) {
        let first = run * RUN;
        let nodes = self.nodes.get(first..).unwrap_or_default();
        let contacts = self.contacts.get(first..).unwrap_or_default();
        let mut seen = [(f64::INFINITY, 0.0); RUN + 1];
        let mut best = found.along;
        for (here, node) in seen.iter_mut().zip(nodes) {
            *here = asked.ray.of(*node);
        }
        // The straight sides first: they are quickly asked, and lie below most of the noses beside them.
        for (pair, contacts) in seen.windows(2).zip(contacts) {
            if let [a, b] = *pair {
                best = best.min(flat(asked, a, b, contacts));
            }
        }
        best = self.noses(asked, &seen, best);
        if best < found.along {
            *found = Found { along: best, run };
        }
    }

    /// Where the ray first meets a nose standing at one of these places, along and over it; `best` where not below.
    fn noses(&self, asked: &Asked, seen: &[(f64, f64)], best: f64) -> f64 {
        if self.nose.is_round() {
            return seen
                .iter()
                .fold(best, |best, here| asked.lower(*here, best));
        }
        let mut turn = 0.0;
        let mut depth = |best: f64, (along, over): (f64, f64)| {
            let depth = self.nose.depth(asked.angle, over, &mut turn);
            depth.map_or(best, |depth| best.min(along - depth))
        };
        let Some((_, first)) = lowest_of(asked, seen, best) else {
            return best;
        };
        // The one that may reach lowest does, mostly: few others are left to be asked.
        let best = depth(best, first);
        seen.iter().fold(best, |best, here| {
            if *here != first && asked.low(*here) < best {
                depth(best, *here)
            } else {
                best
            }
        })
    }
}

/// The place from which the nose may reach lowest on the ray, if below `best`.
fn lowest_of(asked: &Asked, seen: &[(f64, f64)], best: f64) -> Option<(f64, (f64, f64))> {
    seen.iter().fold(None, |found, here| {
        let low = asked.low(*here);
        (low < found.map_or(best, |(low, _)| low))
            .then_some((low, *here))
            .or(found)
    })
}

/// Where the ray meets the straight side between the contacts of a segment's two ends; infinite when it passes beside.
fn flat(asked: &Asked, a: (f64, f64), b: (f64, f64), contacts: &[Point; 2]) -> f64 {
    let ray = &asked.ray;
    // Of the two sides the one whose normal looks along the ray: travel to greater `across` has it on its right.
    let [left, right] = contacts;
    let contact = if a.1 < b.1 { right } else { left };
    let (along, over) = (ray.along(*contact), ray.over(*contact));
    let (from, to) = (a.1 + over, b.1 + over);
    if (from > 0.0) == (to > 0.0) || from == to {
        return f64::INFINITY;
    }
    let share = from / (from - to);
    let centre = a.0 + share * (b.0 - a.0);
    if centre <= asked.floor {
        return f64::INFINITY;
    }
    centre + along
}

fn contacts_of(a: Point, b: Point, nose: &Nose) -> [Point; 2] {
    let (dx, dz) = (b[0] - a[0], b[1] - a[1]);
    let length = (dx * dx + dz * dz).sqrt();
    if length <= 0.0 {
        return [[0.0; 2]; 2];
    }
    let left = [dz / length, -dx / length];
    [nose.contact(left), nose.contact([-left[0], -left[1]])]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn round(radius: f64) -> Nose {
        Nose::new(radius, 0.0, 1.0, Vec::new()).expect("round")
    }

    #[test]
    fn a_straight_cut_leaves_a_straight_line() {
        for nodes in [
            vec![[10.8, 0.0], [10.8, 50.0]],
            vec![[10.8, 50.0], [10.8, 0.0]],
        ] {
            let sweep = Sweep::new(nodes, round(0.8));
            let rays = (1..40).map(|k| (Ray::new([9.9, k as f64], [1.0, 0.0]), 1.0));
            for height in sweep.entries(rays, 1.0) {
                assert!((height - 0.1).abs() < 1e-12, "{height}");
            }
        }
    }

    #[test]
    fn beyond_the_end_the_nose_leaves_its_own_arc() {
        let sweep = Sweep::new(vec![[10.8, 0.0], [10.8, 50.0]], round(0.8));
        let height = sweep.entries(
            std::iter::once((Ray::new([10.0, 50.5], [1.0, 0.0]), 2.0)),
            2.0,
        );
        assert!((height[0] - (0.8 - (0.64_f64 - 0.25).sqrt())).abs() < 1e-12);
        let none = sweep.entries(
            std::iter::once((Ray::new([10.0, 60.0], [1.0, 0.0]), 2.0)),
            2.0,
        );
        assert_eq!(none, vec![2.0]);
    }

    #[test]
    fn nothing_swept_is_nothing_cut() {
        assert_eq!(
            Sweep::new(Vec::new(), round(0.8))
                .entries([(Ray::new([0.0; 2], [1.0, 0.0]), 1.0)].into_iter(), 1.0),
            vec![1.0]
        );
    }
}
