//! Places that PATTERN DEF of Klartext names, and CYCL CALL PAT, which runs the cycle defined last at each of them.

use crate::drilling::hole_places::{around, to_and_fro, Spans, MOST};
use crate::finding::Unseen;
use crate::path::{MoveKind, INHERITED};
use crate::run::Runner;

/// A place of a pattern: its coordinates in the plane, and by how much the workpiece is higher there, mm.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PatternPlace {
    at: [f64; 2],
    higher: f64,
    /// Where the coordinates are written from which it counts, and that height.
    said: Spans,
    height: (u32, u32),
}

/// `ROW1 (X+25 Y+33.5 D+8 NUM5 ROT+0 Z+0)`: its name without the number, its values and where they are written.
struct Element {
    kind: String,
    values: Vec<(String, f64, (u32, u32))>,
}

impl Element {
    fn get(&self, key: &str) -> Result<f64, String> {
        let value = self.values.iter().find(|(known, ..)| known == key).map(|(_, value, _)| *value);
        value.filter(|value| value.is_finite()).ok_or_else(|| format!("{key} of {} is not given", self.kind))
    }

    fn or_zero(&self, key: &str) -> f64 {
        self.get(key).unwrap_or(0.0)
    }

    fn count(&self, key: &str) -> Result<usize, String> {
        let count = self.get(key)?;
        let fits = count.fract() == 0.0 && (1.0..=MOST).contains(&count);
        if fits {
            Ok(count as usize)
        } else {
            Err(format!("{key} is {count}"))
        }
    }

    fn span(&self, key: &str) -> (u32, u32) {
        self.values.iter().find(|(known, ..)| known == key).map_or((0, 0), |(.., span)| *span)
    }

    /// Its places, program units.
    fn places(&self) -> Result<Vec<[f64; 2]>, String> {
        let first = [self.get("X")?, self.get("Y")?];
        let turn = self.or_zero("ROT");
        if [self.or_zero("ROTX"), self.or_zero("ROTY")] != [0.0; 2] {
            return Err("its lines are turned one against the other (ROTX, ROTY)".to_owned());
        }
        match self.kind.as_str() {
            "POS" => Ok(vec![first]),
            "ROW" => {
                let (count, by) = (self.count("NUM")?, self.get("D")?);
                Ok((0..count).map(|index| around(first, index as f64 * by, turn)).collect())
            }
            "PAT" | "FRAME" => {
                let (columns, rows) = (self.count("NUMX")?, self.count("NUMY")?);
                let by = [self.get("DX")?, self.get("DY")?];
                if columns.saturating_mul(rows) as f64 > MOST {
                    return Err(format!("it has {columns} x {rows} places"));
                }
                let on_frame = |[row, column]: [usize; 2]| {
                    self.kind == "PAT" || row == 0 || column == 0 || row + 1 == rows || column + 1 == columns
                };
                let all = (0..rows * columns).map(|index| [index / columns, index % columns]);
                Ok(all.filter(|at| on_frame(*at)).map(|at| to_and_fro(first, turn, by, at, columns)).collect())
            }
            "CIRC" | "PITCHCIRC" => {
                let (count, radius, start) = (self.count("NUM")?, self.get("D")? / 2.0, self.get("START")?);
                let step = if self.kind == "CIRC" { Ok(360.0 / count as f64) } else { self.get("STEP") };
                let step =
                    step.or_else(|_| self.get("END").map(|end| (end - start) / count.saturating_sub(1).max(1) as f64))?;
                Ok((0..count).map(|index| around(first, radius, start + index as f64 * step)).collect())
            }
            other => Err(format!("the pattern {other} is not followed")),
        }
    }
}

impl Runner<'_> {
    /// PATTERN DEF: its places are those of the next CYCL CALL PAT.
    pub(crate) fn define_pattern(&mut self, word: i32) {
        self.state.pattern_places = self.pattern_of(word).unwrap_or_else(|why| {
            self.not_followed(word, &why);
            Vec::new()
        });
    }

    fn pattern_of(&mut self, word: i32) -> Result<Vec<PatternPlace>, String> {
        let (mm, mut all) = (self.state.modal.mm(), Vec::new());
        for element in self.elements(word)? {
            let (higher, height) = (element.or_zero("Z") * mm, element.span("Z"));
            let said = ["X", "Y"].map(|key| element.span(key));
            let places = element.places()?.into_iter();
            all.extend(places.map(|at| PatternPlace { at: at.map(|one| one * mm), higher, said, height }));
        }
        Ok(all)
    }

    /// The elements of a definition, which goes on in the next line behind a `~`.
    fn elements(&mut self, word: i32) -> Result<Vec<Element>, String> {
        let (program, start) = (self.program, self.word_start(word) + "PATTERN DEF".len());
        let mut text: Vec<(char, usize)> = Vec::new();
        for block in program.blocks().get(self.block..).unwrap_or(&[]) {
            let line = program.source().get(block.start as usize..block.end as usize).unwrap_or(&[]);
            let said = line.iter().position(|byte| *byte == b';').unwrap_or(line.len());
            let of_line = line.iter().take(said).enumerate().map(|(at, byte)| (*byte, block.start as usize + at));
            text.extend(
                of_line
                    .filter(|(byte, at)| *at >= start && *byte != b'~')
                    .map(|(byte, at)| (char::from(byte.to_ascii_uppercase()), at)),
            );
            text.push((' ', block.end as usize));
            if !line.trim_ascii_end().ends_with(b"~") {
                break;
            }
        }
        let (mut elements, mut rest): (Vec<Element>, &[(char, usize)]) = (Vec::new(), &text);
        while let Some(from) = rest.iter().position(|(one, _)| one.is_ascii_alphabetic()) {
            let of_element = rest.get(from..).unwrap_or(&[]);
            let opens = of_element.iter().position(|(one, _)| *one == '(');
            let closes = of_element.iter().position(|(one, _)| *one == ')');
            let (Some(opens), Some(closes)) = (opens, closes) else { return Err("its brackets do not fit".to_owned()) };
            let kind = of_element.iter().take(opens).map(|(one, _)| *one).filter(char::is_ascii_alphabetic).collect();
            let inside = of_element.get(opens + 1..closes).ok_or("its brackets do not fit")?;
            let mut values = Vec::new();
            for token in inside.split(|(one, _)| *one == ' ').filter(|token| !token.is_empty()) {
                let digits = token.iter().position(|(one, _)| !one.is_ascii_alphabetic() || *one == 'Q');
                let at = digits.filter(|at| *at > 0).ok_or("a value of it has no number")?;
                let key: String = token.iter().take(at).map(|(one, _)| *one).collect();
                let written: String = token.iter().skip(at).map(|(one, _)| *one).collect();
                let (begins, ends) = (token[at].1, token[token.len() - 1].1 + 1);
                let value = written.replace(',', ".").parse().unwrap_or_else(|_| self.value(begins).0);
                values.push((key, value, (begins as u32, ends as u32)));
            }
            elements.push(Element { kind, values });
            rest = of_element.get(closes + 1..).unwrap_or(&[]);
        }
        Ok(elements)
    }

    /// CYCL CALL PAT: from place to place at the height where the tool stood or Q204, whichever is higher.
    pub(crate) fn call_pattern(&mut self, word: i32) {
        let places = self.state.pattern_places.clone();
        let third = self.state.modal.plane.axes().2;
        let Some((number, drill)) = self.state.defined.cycle.filter(|_| !places.is_empty()) else {
            return self.warn_unseen(
                word,
                Unseen::Nothing,
                "the cycle defined last, or its pattern, is not in the path",
            );
        };
        let stood = self.state.position[third];
        for place in places {
            let mut hole = match self.hole_at_places(number, drill) {
                Ok(hole) => hole,
                Err(why) => return self.not_followed(word, &why),
            };
            if place.higher != 0.0 {
                hole.raise(place.higher, place.height);
            }
            let hole = hole.ending_at(stood);
            if self.state.position[third] < hole.retract() {
                self.height(MoveKind::Rapid, self.state.position, third, hole.retract(), INHERITED);
            }
            self.go_to_place(place.at, place.said);
            self.drill_here(&hole);
        }
    }
}
