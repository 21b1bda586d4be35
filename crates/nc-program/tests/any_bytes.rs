//! Whatever the bytes: nothing panics, nothing is lost, spans are in order.

use nc_program::{
    dialect::dialects, lint, offset_statements, parameters_used, run, Dialect, MoveKind, Options, Program, Tool,
};
use proptest::prelude::*;

/// Pieces of programs, of every kind, with bars between.
const PIECES: &[&str] = &[
    "G1|g02|G81|G83 Q1e-3 L9999|G98|G80|G92|G54|G10 L2 P2|G53|G28|G43.1|G41|G42.1 D2|G40|X|Z-1.5|X(|)|[|]|#|#<a>",
    "#1=|##2|P46|P1=|P2=-1|(UPD, 1, TOV(X), 0.1)|!|;|(|/|%|\n|\r\n| |\t|\0|,|.|+|-|*|**|=|1e9",
    "99999999999999999999|I0.5|K-1|R2|R-3|F10|o1 sub\n|o1 endsub\n|o1 call [1]\n|o2 while [#1 LT 3]\n",
    "o2 endwhile\n|o3 if [1]\n|o3 else\n|o3 endif\n|o2 break\n|o2 continue\n|o4 repeat [5]\n|o4 endrepeat\n",
    "o5 do\n|o5 while [0]\n|o|SIN[|ATAN[1]/[2]|MOD|EXISTS[#<b>]|\nN10 |\nO20 |G71P10Q20|G70P10Q20|M98P20|L3|M99",
    "M97P10|,R1.|G76 P1 Z-9 I-1 J.1 K1|G76 X1. Z-9. P1000 Q9|G90 X1. Z-2.|G92 U1. W-2. R9.|G87 X1. R-1.",
    "G65 P20 X1.|G54.1 P2|G43 H1|@5|^30|G4 P1.|,C1|A30.|RNDM=1|CHF=1|U1.|IF[#1EQ#0]GOTO10\n",
    "IF[#2GT1]THEN#1=#2+1\n|GOTO20\n|WHILE[#1LT3]DO1\n|DO2\n|END1\n|END2\n|G7|G8|G90.1|G91|G17|G19|G20|M2|M70",
    "M72|M73|é|X#1|Z[#1+1]|T0101|S100|G96|N10|R1=R2+|R[R1]=2\n|X=IC(|X=AC(1)|CR=-3|CT|CIP|I1=2|AR=90|AP=IC(30)",
    "RP=5|ANG=45|G111|TURN=2|DIAM90 |TRANS |ATRANS X1|SUPA |MEAS=1|CHR=.5|$AA_IW[X]|A_B[1,2]=3|NOT |==|<<|\"",
    "DEF REAL A=1, B\n|IF R1==1\n|ELSE\n|ENDIF\n|WHILE R1<3\n|ENDWHILE\n|FOR R1=1 TO 3\n|ENDFOR\n|LOOP\n",
    "ENDLOOP\n|REPEAT\n|UNTIL R1>1\n|IF R1<2 GOTOB A_1\n|GOTOF A_1\n|A_1:|\n%_N_SUB_SPF\n|SUB P2\n|L10\n|M17\n",
    "CYCLE83(1,|MSG(\"|\n12 L |X+Q1|IX5|CC |C |DR-|CR |CT |LP PR5|CP IPA+900|FMAX|RND R2|\nLBL 1\n|\nLBL 0\n",
    "\nCALL LBL 1 REP 3\n|\nCALL LBL 1\n|\nFN 12: IF +Q1 LT +3 GOTO LBL 1\n|FN 1: Q1 = +Q1 + +1\n|Q2 = SQRT ",
    "CYCL DEF 7.1 |CYCL DEF 200 D\nQ200=2\nQ201=-5\nQ203=1\n|Q203=| M99\n| M89\n|TOOL CALL 5 Z|~",
    "BEGIN PGM A INCH\n",
];

/// Bytes that come near to programs: pieces of every kind, in any order.
fn near_programs() -> impl Strategy<Value = Vec<u8>> {
    let pieces: Vec<&str> = PIECES.iter().flat_map(|line| line.split('|')).collect();
    let pieces = prop::sample::select(pieces);
    prop::collection::vec(pieces, 0..60).prop_map(|pieces| pieces.concat().into_bytes())
}

fn everything(source: &[u8], dialect: &'static Dialect) -> Result<(), TestCaseError> {
    let program = Program::read(source.to_vec(), dialect).unwrap();
    prop_assert_eq!(program.source(), source);
    spans_are_in_order(&program)?;
    lint(&program);
    parameters_used(&program);
    offset_statements(&program);
    for optional_blocks in [false, true] {
        let tools = if optional_blocks {
            vec![Tool {
                number: None,
                radius: 1.5,
                tip: Some(3),
                length: Some(9.0),
                offset: Some([3.0, 0.0, 1.0]),
                edge: None,
            }]
        } else {
            Vec::new()
        };
        let options = Options { optional_blocks, tools, block_limit: 2000, roughing: true, ..Options::default() };
        let (path, findings) = run(&program, &options);
        prop_assert!(findings.iter().all(|finding| finding.at <= source.len()));
        for index in 0..path.len() {
            prop_assert!((path.block[index] as usize) < program.blocks().len());
            prop_assert!((path.state[index] as usize) < path.states.len());
            prop_assert!(path.column(index, &program) >= 1);
            prop_assert!(path.words[index].iter().all(|word| *word < program.words().len() as i32));
        }
        let of_moves: Vec<usize> = (0..path.len()).filter(|index| path.kind[*index] == MoveKind::Arc).collect();
        prop_assert_eq!(path.arcs.iter().map(|arc| arc.of_move).collect::<Vec<_>>(), of_moves);
    }
    Ok(())
}

fn spans_are_in_order(program: &Program) -> Result<(), TestCaseError> {
    let mut at = 0;
    for (index, block) in program.blocks().iter().enumerate() {
        prop_assert!(block.start as usize == at && block.start <= block.end);
        let mut from = block.start;
        for word in program.words_of(index) {
            prop_assert!(from <= word.start && word.length > 0 && word.end() <= block.end as usize);
            prop_assert!((word.start as usize..=word.end()).contains(&program.value_start(word)));
            prop_assert_eq!(program.block_at(word.start as usize), index);
            from = word.end() as u32;
        }
        let line = &program.source()[at..];
        at += line.iter().position(|byte| *byte == b'\n').map_or(line.len(), |found| found + 1);
    }
    prop_assert_eq!(at, program.source().len());
    let words: usize = (0..program.blocks().len()).map(|block| program.words_of(block).len()).sum();
    prop_assert_eq!(words, program.words().len());
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_bytes(source in prop::collection::vec(any::<u8>(), 0..400)) {
        for dialect in dialects() {
            everything(&source, dialect)?;
        }
    }

    #[test]
    fn nearly_programs(source in near_programs()) {
        for dialect in dialects() {
            everything(&source, dialect)?;
        }
    }
}

/// Beginnings of what may run to the end of its line.
const OPEN: &[&str] = &[
    "X[ |X( |#<|#< |()|( |X#[ |P1=( |SIN[ |X 1 . |o[ |X1 X2 |##|[[|X-|?? |,R|,R[ |GOTO|DO1 |IF[ |#1=[ ",
    "A[ |X=( |X=A( |A=\"|A= |X=1+ |AB |AB( |A:|GOTOF |MSG( |IF |$A[|X=-|FOR |SIN |X R1 |LBL 1\n",
    "CALL LBL 1 REP 9\n|FN 9: |Q1 = SIN ",
];

/// Each of these makes a careless reader look through the rest of its line from every word. A megabyte of it then takes
/// minutes; the test ends at once or not at all.
#[test]
fn long_lines_take_linear_time() {
    for piece in OPEN.iter().flat_map(|line| line.split('|')) {
        let source = piece.repeat(1_000_000 / piece.len());
        for dialect in dialects() {
            let program = Program::read(source.clone().into_bytes(), dialect).unwrap();
            lint(&program);
            parameters_used(&program);
            run(&program, &Options::default());
        }
    }
}

#[test]
fn carriage_returns_within_a_line_end_with_its_block() {
    for dialect in dialects() {
        everything(b"\0\r\0\r\n", dialect).unwrap();
    }
}

#[test]
fn text_longer_than_a_word_is_kept_in_pieces() {
    for text in ["?".repeat(200_000), format!("X[{}]", "1+".repeat(100_000)), format!("o{}", "9".repeat(70_000))] {
        let program = Program::read(text.clone().into_bytes(), Dialect::named("linuxcnc").unwrap()).unwrap();
        let kept: Vec<u8> = program.words().iter().flat_map(|word| program.text(word).to_vec()).collect();
        assert_eq!(kept, text.as_bytes());
    }
}

#[test]
fn deep_brackets_are_refused() {
    let source = format!("G21 G0 X{}1{}", "[".repeat(10_000), "]".repeat(10_000));
    let program = Program::read(source.into_bytes(), Dialect::named("linuxcnc").unwrap()).unwrap();
    let (_, findings) = run(&program, &Options::default());
    assert_eq!(findings.len(), 1);
    assert_eq!(findings[0].code, "NC-EXPRESSION");
}

#[test]
fn the_source_is_not_copied() {
    let source = bytes::Bytes::from_static(b"G21\nG0 X1\n");
    let program = Program::read(source.clone(), Dialect::named("linuxcnc").unwrap()).unwrap();
    assert!(std::ptr::eq(program.source(), source.as_ref()));
}
