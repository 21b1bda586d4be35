//! Any bytes, in every dialect: kept as they are, with blocks and words in order and within them.
#![no_main]

use libfuzzer_sys::fuzz_target;
use nc_program::dialect::dialects;
use nc_program::{jumps, lint, offset_statements, parameters_used, Program};

fuzz_target!(|source: &[u8]| {
    for dialect in dialects() {
        let program = Program::read(source.to_vec(), dialect).expect("a fuzzer's inputs are small");
        assert_eq!(program.source(), source);
        let mut end = 0;
        for block in program.blocks() {
            assert!(end <= block.start as usize && block.start <= block.end);
            end = block.end as usize;
        }
        assert!(end <= source.len());
        let mut end = 0;
        for word in program.words() {
            assert!(end <= word.start as usize && (word.start as usize) < word.end());
            end = word.end();
            assert!((word.start as usize..=end).contains(&program.value_start(word)));
            assert_eq!(program.text(word).len(), usize::from(word.length));
        }
        assert!(end <= source.len());
        lint(&program);
        jumps(&program);
        parameters_used(&program);
        for statement in offset_statements(&program) {
            assert!(statement.value_start < statement.value_end && statement.value_end <= source.len());
        }
    }
});
