//! Any bytes, run in every dialect: bounded, whole columns, and the same path again.
#![no_main]

use libfuzzer_sys::fuzz_target;
use nc_program::dialect::dialects;
use nc_program::{run, Options, Program};

/// Blocks of one run: enough for every construct, few enough for many runs a second.
const BLOCKS: usize = 2_000;

fuzz_target!(|source: &[u8]| {
    for dialect in dialects() {
        let program = Program::read(source.to_vec(), dialect).expect("a fuzzer's inputs are small");
        let optional_blocks = source.len() % 2 == 1;
        let options = Options { optional_blocks, block_limit: BLOCKS, roughing: true, ..Options::default() };
        let (path, findings) = run(&program, &options);
        let moves = path.len();
        assert_eq!([path.start.len(), path.end.len(), path.words.len()], [moves; 3]);
        assert_eq!([path.block.len(), path.state.len()], [moves; 2]);
        for index in 0..moves {
            assert!((path.block[index] as usize) < program.blocks().len());
            assert!((path.state[index] as usize) < path.states.len());
            assert!(path.words[index].iter().all(|word| *word < program.words().len() as i32));
            assert!(path.column(index, &program) > 0);
        }
        assert!(path.arcs.windows(2).all(|pair| pair[0].of_move < pair[1].of_move));
        assert!(path.arcs.iter().all(|arc| arc.of_move < moves && arc.sweep != 0.0));
        assert!(findings.iter().all(|finding| finding.at <= source.len()));
    }
});
