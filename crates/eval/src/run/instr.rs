//! Instructions: each is one loop over the lanes of a block.

use super::lanes::{Bank, Banks, LANES, Operand, Row, each, inlined, map1, map2, map3, put, select_rows, slow};
use crate::code::{Code, File, Instr, Lookup, Op};
use crate::number::{Binary, Bool, Comparison, Domain, IntBinary, Integer, Number, Unary};
use crate::texture::Image;

/// Dispatches on a function outside the loop over lanes, for the listed ones.
macro_rules! known {
    ($kinds:ident, $choice:expr, [$($kind:ident)*], |$name:ident| $fast:expr $(, $slow:expr)?) => {
        match $choice {
            $($kinds::$kind => {
                const $name: $kinds = $kinds::$kind;
                $fast
            })*
            $(_ => $slow,)?
        }
    };
}

impl<N: Number> Banks<N> {
    /// Runs an instruction for the lanes of a mask; `block` has all lanes that are in use.
    #[inline(always)] // into code for the vectors of this processor
    pub(crate) fn run(&mut self, instr: &Instr, code: &Code, images: &[Image<'_>], mask: u64, block: u64) {
        let [a, b, c] = instr.sources;
        let signed = instr.signed;
        let Banks {
            floats: Bank { rows: f, spare: float },
            ints: Bank { rows: i, spare: int },
            bools: Bank { rows: t, spare: bool },
            splits,
        } = self;
        match instr.op {
            Op::Nop => {}
            Op::Copy => match instr.dst.file {
                File::Float => inlined!(map1(float, mask, f.read(a)), |x| x),
                File::Int => inlined!(map1(int, mask, i.read(a)), |x| x),
                File::Bool => inlined!(map1(bool, mask, t.read(a)), |x| x),
            },
            Op::Unary(function @ (Unary::Floor | Unary::Fract)) if !N::DECIDED && !splits.is_empty() => {
                let a = f.read(a);
                each(mask, |lane| put(float, lane, a.at(lane).unary_split(function, &mut splits[lane])));
            }
            Op::Unary(function) => known!(
                Unary,
                function,
                [Negate Abs Sign Floor Ceil Trunc Fract Saturate Square Sqrt InverseSqrt Hermite],
                |KNOWN| inlined!(map1(float, mask, f.read(a)), |x| x.unary(KNOWN)),
                slow(float, mask, f.read(a), |x| x.unary(function))
            ),
            Op::Binary(function) => known!(
                Binary,
                function,
                [Add Sub Mul Div Min Max Unit],
                |KNOWN| inlined!(map2(float, mask, (f.read(a), f.read(b))), |a, b| a.binary(KNOWN, b)),
                slow(float, mask, (f.read(a), f.read(b)), |(a, b)| a.binary(function, b))
            ),
            Op::MulAdd => inlined!(map3(float, mask, (f.read(a), f.read(b), f.read(c))), |a, b, c| {
                a.binary(Binary::Mul, b).binary(Binary::Add, c)
            }),
            Op::Mix => inlined!(map3(float, mask, (f.read(a), f.read(b), f.read(c))), |a, b, c| a.mix(b, c)),
            Op::Compare(comparison) => known!(
                Comparison,
                comparison,
                [Less LessEqual Equal],
                |KNOWN| inlined!(map2(bool, mask, (f.read(a), f.read(b))), |a: N, b| a.compare(KNOWN, b))
            ),
            Op::IsNan => map1(bool, mask, f.read(a), N::is_nan),
            Op::IsInfinite => map1(bool, mask, f.read(a), N::is_infinite),
            Op::ToInt => inlined!(map1(int, mask, f.read(a)), |x: N| x.to_int(signed)),
            Op::FromInt => inlined!(map1(float, mask, i.read(a)), |x| N::from_int(x, signed)),
            Op::ToBits => map1(int, mask, f.read(a), |x| x.to_bits(signed)),
            Op::FromBits => map1(float, mask, i.read(a), N::from_bits),
            Op::Ldexp => slow(float, mask, (f.read(a), i.read(b)), |(a, b)| a.ldexp(b)),
            Op::Select => match instr.dst.file {
                File::Float if N::DECIDED => {
                    inlined!(map3(float, mask, (t.read(a), f.read(b), f.read(c))), |t, a, b| N::select(t, a, b))
                }
                File::Float => select_rows(float, mask, t.read(a), (f.read(b), f.read(c))),
                File::Int => map3(int, mask, (t.read(a), i.read(b), i.read(c)), N::Int::select),
                File::Bool => map3(bool, mask, (t.read(a), t.read(b), t.read(c)), N::Bool::select),
            },
            Op::Int(function) => known!(
                IntBinary,
                function,
                [Add Sub Mul And Or Xor ShiftLeft ShiftRight],
                |KNOWN| inlined!(map2(int, mask, (i.read(a), i.read(b))), |a: N::Int, b| a.binary(KNOWN, b, signed)),
                slow(int, mask, (i.read(a), i.read(b)), |(a, b)| a.binary(function, b, signed))
            ),
            Op::IntUnary(function) => slow(int, mask, i.read(a), |a| a.unary(function, signed)),
            Op::Bitcast => inlined!(map1(int, mask, i.read(a)), |x: N::Int| x.bitcast(signed)),
            Op::IntLess => inlined!(map2(bool, mask, (i.read(a), i.read(b))), |a: N::Int, b| a.less(b, signed)),
            Op::IntEqual => inlined!(map2(bool, mask, (i.read(a), i.read(b))), |a: N::Int, b| a.equal(b)),
            Op::And => inlined!(map2(bool, mask, (t.read(a), t.read(b))), |a: N::Bool, b| a.and(b)),
            Op::Or => inlined!(map2(bool, mask, (t.read(a), t.read(b))), |a: N::Bool, b| a.or(b)),
            Op::BoolEqual => inlined!(map2(bool, mask, (t.read(a), t.read(b))), |a: N::Bool, b| a.equal(b)),
            Op::Not => inlined!(map1(bool, mask, t.read(a)), |a: N::Bool| a.not()),
            Op::Gather => {
                let (table, index) = (&code.tables[instr.table as usize], i.read(a));
                match instr.dst.file {
                    File::Float => gather(float, mask, index, table.len(), |at, lane| f.read(table[at]).at(lane)),
                    File::Int => gather(int, mask, index, table.len(), |at, lane| i.read(table[at]).at(lane)),
                    File::Bool => gather(bool, mask, index, table.len(), |at, lane| t.read(table[at]).at(lane)),
                }
            }
            Op::Sample => return self.sample(&code.lookups[instr.table as usize], images, mask),
            Op::Fetch => return self.fetch(&code.lookups[instr.table as usize], images, mask),
            Op::Derivative(along_y) => {
                let (a, step) = (f.read(a), if along_y { 2 } else { 1 });
                for lane in 0..LANES {
                    put(float, lane, a.at(lane | step).binary(Binary::Sub, a.at(lane & !step)));
                }
            }
        }
        let all = !instr.masked || mask == block;
        match instr.dst.file {
            _ if instr.op == Op::Nop => {}
            File::Float => self.floats.store_result(instr.dst, mask, all),
            File::Int => self.ints.store_result(instr.dst, mask, all),
            File::Bool => self.bools.store_result(instr.dst, mask, all),
        }
    }

    fn sample(&mut self, lookup: &Lookup, images: &[Image<'_>], mask: u64) {
        let wanted = lookup.channels.map(|channel| channel.is_some());
        let mut found = [[N::new(0.0); 4]; LANES];
        let axes = images[lookup.image].axes;
        let row = |index: usize| lookup.at.get(index).map(|reg| self.floats.rows.read(*reg));
        let at = [0, 1, 2].map(|axis| row(axis).filter(|_| axis < axes));
        let level = row(axes);
        each(mask, |lane| {
            let of = |row: Option<Operand<'_, N>>| row.map_or(N::new(0.0), |row| row.at(lane));
            found[lane] = N::sample(&images[lookup.image], at.map(of), of(level), wanted);
        });
        self.spread(lookup, &found, mask);
    }

    fn fetch(&mut self, lookup: &Lookup, images: &[Image<'_>], mask: u64) {
        let mut found = [[N::new(0.0); 4]; LANES];
        let at = [0, 1, 2].map(|axis| lookup.at.get(axis).map(|reg| self.ints.rows.read(*reg)));
        each(mask, |lane| {
            let at = at.map(|axis| axis.map_or(N::Int::new(0, true), |axis| axis.at(lane)));
            found[lane] = N::fetch(&images[lookup.image], at);
        });
        self.spread(lookup, &found, mask);
    }

    fn spread(&mut self, lookup: &Lookup, found: &[[N; 4]; LANES], mask: u64) {
        for (channel, reg) in lookup.channels.iter().enumerate() {
            if let Some(reg) = reg {
                let row = self.floats.row(*reg);
                each(mask, |lane| put(row, lane, found[lane][channel]));
            }
        }
    }
}

/// Reads a table; joins all elements that an undecided index may select.
fn gather<I: Integer, T: Domain>(
    out: &mut Row<T>,
    mask: u64,
    index: Operand<'_, I>,
    count: usize,
    value: impl Fn(usize, usize) -> T,
) {
    each(mask, |lane| {
        let (first, last) = index.at(lane).index(count);
        put(out, lane, (first + 1..=last).fold(value(first, lane), |all, at| all.join(value(at, lane))));
    });
}
