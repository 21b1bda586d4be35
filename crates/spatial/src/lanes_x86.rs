//! Eight numbers at once on the processors that have AVX2 or AVX-512.

mod avx2 {
    use crate::lanes::{Eight, Lanes};
    use core::arch::x86_64::{__m256d, _CMP_GT_OQ};
    use pulp::bytemuck::cast;
    use pulp::x86::V3;

    type Halves = [__m256d; 2];

    #[inline(always)]
    fn each(f: impl Fn(usize) -> __m256d) -> Halves {
        [f(0), f(1)]
    }

    impl Lanes for V3 {
        type Vector = Halves;
        const TERMS: usize = 5;

        #[inline(always)]
        fn load(self, values: &Eight) -> Halves {
            cast(*values)
        }

        #[inline(always)]
        fn store(self, values: Halves) -> Eight {
            cast(values)
        }

        #[inline(always)]
        fn add(self, a: Halves, b: Halves) -> Halves {
            each(|k| self.avx._mm256_add_pd(a[k], b[k]))
        }

        #[inline(always)]
        fn subtract(self, a: Halves, b: Halves) -> Halves {
            each(|k| self.avx._mm256_sub_pd(a[k], b[k]))
        }

        #[inline(always)]
        fn multiply(self, a: Halves, b: Halves) -> Halves {
            each(|k| self.avx._mm256_mul_pd(a[k], b[k]))
        }

        #[inline(always)]
        fn greater(self, a: Halves, b: Halves) -> Halves {
            each(|k| self.avx._mm256_max_pd(a[k], b[k]))
        }

        #[inline(always)]
        fn multiply_add(self, a: Halves, b: Halves, c: Halves) -> Halves {
            each(|k| self.fma._mm256_fmadd_pd(a[k], b[k], c[k]))
        }

        #[inline(always)]
        fn subtract_product(self, c: Halves, a: Halves, b: Halves) -> Halves {
            each(|k| self.fma._mm256_fnmadd_pd(a[k], b[k], c[k]))
        }

        /// In single precision: good for a from 1e-37 to 1e38, to a part in 2700.
        #[inline(always)]
        fn rough_inverse_root(self, a: Halves, least: Halves) -> Halves {
            each(|k| {
                let rough = self.sse._mm_rsqrt_ps(self.avx._mm256_cvtpd_ps(a[k]));
                let above = self.avx._mm256_cmp_pd::<_CMP_GT_OQ>(a[k], least[k]);
                self.avx
                    ._mm256_and_pd(self.avx._mm256_cvtps_pd(rough), above)
            })
        }
    }
}

mod avx512 {
    use crate::lanes::{Eight, Lanes};
    use core::arch::x86_64::{__m512d, _CMP_GT_OQ};
    use pulp::bytemuck::cast;
    use pulp::x86::V4;

    impl Lanes for V4 {
        type Vector = __m512d;
        const TERMS: usize = 4;

        #[inline(always)]
        fn load(self, values: &Eight) -> __m512d {
            cast(*values)
        }

        #[inline(always)]
        fn store(self, values: __m512d) -> Eight {
            cast(values)
        }

        #[inline(always)]
        fn add(self, a: __m512d, b: __m512d) -> __m512d {
            self.avx512f._mm512_add_pd(a, b)
        }

        #[inline(always)]
        fn subtract(self, a: __m512d, b: __m512d) -> __m512d {
            self.avx512f._mm512_sub_pd(a, b)
        }

        #[inline(always)]
        fn multiply(self, a: __m512d, b: __m512d) -> __m512d {
            self.avx512f._mm512_mul_pd(a, b)
        }

        #[inline(always)]
        fn greater(self, a: __m512d, b: __m512d) -> __m512d {
            self.avx512f._mm512_max_pd(a, b)
        }

        #[inline(always)]
        fn multiply_add(self, a: __m512d, b: __m512d, c: __m512d) -> __m512d {
            self.avx512f._mm512_fmadd_pd(a, b, c)
        }

        #[inline(always)]
        fn subtract_product(self, c: __m512d, a: __m512d, b: __m512d) -> __m512d {
            self.avx512f._mm512_fnmadd_pd(a, b, c)
        }

        #[inline(always)]
        fn rough_inverse_root(self, a: __m512d, least: __m512d) -> __m512d {
            let above = self.avx512f._mm512_cmp_pd_mask::<_CMP_GT_OQ>(a, least);
            self.avx512f._mm512_maskz_rsqrt14_pd(above, a)
        }
    }
}
