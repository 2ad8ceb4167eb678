//! Instructions: each is one loop over the lanes of a block.

use super::code::{Code, File, Instr, Lookup, Op};
use super::lanes::{Bank, Banks, LANES, Operand, Row, choose, each, map1, map2, map3, put, slow};
use super::number::{IntBinary, Integer, Number, Packed, Truth, Unary};
use super::texture::Image;

/// A choice among functions, made before the loop over lanes for those that are worth it.
macro_rules! known {
    ($kinds:ident, $choice:expr, [$($kind:ident)*], |$name:ident| $fast:expr, $slow:expr) => {
        match $choice {
            $($kinds::$kind => {
                const $name: $kinds = $kinds::$kind;
                $fast
            })*
            _ => $slow,
        }
    };
}

/// A loop over lanes whose function becomes a part of it, and so of the code for the vectors of this processor.
macro_rules! inlined {
    ($map:ident($out:expr, $mask:expr, $from:expr), $function:expr) => {
        $map(
            $out,
            $mask,
            $from,
            #[inline(always)]
            $function,
        )
    };
}

impl<N: Number> Banks<N> {
    /// Runs an instruction for the lanes of a mask, of those that there are.
    #[inline(always)] // into code for the vectors of this processor
    pub(super) fn run(&mut self, instr: &Instr, code: &Code, images: &[Image<'_>], mask: u64, whole: u64) {
        let [a, b, c] = instr.sources;
        let signed = instr.signed;
        let Banks {
            floats: Bank { rows: f, spare: float },
            ints: Bank { rows: i, spare: int },
            truths: Bank { rows: t, spare: truth },
            cases,
        } = self;
        match instr.op {
            Op::Nop => {}
            Op::Copy => match instr.dst.file {
                File::Float => inlined!(map1(float, mask, f.read(a)), |x| x),
                File::Int => inlined!(map1(int, mask, i.read(a)), |x| x),
                File::Truth => inlined!(map1(truth, mask, t.read(a)), |x| x),
            },
            Op::Unary(function @ (Unary::Floor | Unary::Fract)) if !N::DECIDED && !cases.is_empty() => {
                let a = f.read(a);
                each(mask, |lane| put(float, lane, a.at(lane).in_case(function, &mut cases[lane])));
            }
            Op::Unary(function) => known!(
                Unary,
                function,
                [Negate Abs Sign Floor Ceil Trunc Fract Saturate Square Sqrt InverseSqrt Hermite],
                |KNOWN| inlined!(map1(float, mask, f.read(a)), |x| x.unary(KNOWN)),
                slow(float, mask, f.read(a), |x| x.unary(function))
            ),
            Op::Add => inlined!(map2(float, mask, (f.read(a), f.read(b))), |a, b| a.add(b)),
            Op::Sub => inlined!(map2(float, mask, (f.read(a), f.read(b))), |a, b| a.sub(b)),
            Op::Mul => inlined!(map2(float, mask, (f.read(a), f.read(b))), |a, b| a.mul(b)),
            Op::Div => inlined!(map2(float, mask, (f.read(a), f.read(b))), |a, b| a.div(b)),
            Op::Min => inlined!(map2(float, mask, (f.read(a), f.read(b))), |a, b| a.min(b)),
            Op::Max => inlined!(map2(float, mask, (f.read(a), f.read(b))), |a, b| a.max(b)),
            Op::Unit => inlined!(map2(float, mask, (f.read(a), f.read(b))), |a, b| a.unit(b)),
            Op::Pow => slow(float, mask, (f.read(a), f.read(b)), |(a, b)| a.pow(b)),
            Op::Atan2 => slow(float, mask, (f.read(a), f.read(b)), |(a, b)| a.atan2(b)),
            Op::Rem => slow(float, mask, (f.read(a), f.read(b)), |(a, b)| a.rem(b)),
            Op::MulAdd => inlined!(map3(float, mask, (f.read(a), f.read(b), f.read(c))), |a, b, c| a.mul(b).add(c)),
            Op::Mix => inlined!(map3(float, mask, (f.read(a), f.read(b), f.read(c))), |a, b, c| a.mix(b, c)),
            Op::Less => inlined!(map2(truth, mask, (f.read(a), f.read(b))), |a: N, b| a.less(b)),
            Op::LessEqual => inlined!(map2(truth, mask, (f.read(a), f.read(b))), |a: N, b| a.less_equal(b)),
            Op::Equal => inlined!(map2(truth, mask, (f.read(a), f.read(b))), |a: N, b| a.equal(b)),
            Op::IsNan => map1(truth, mask, f.read(a), N::is_nan),
            Op::IsInfinite => map1(truth, mask, f.read(a), N::is_infinite),
            Op::ToInt => inlined!(map1(int, mask, f.read(a)), |x: N| x.to_int(signed)),
            Op::FromInt => inlined!(map1(float, mask, i.read(a)), |x| N::from_int(x, signed)),
            Op::ToBits => map1(int, mask, f.read(a), |x| x.to_bits(signed)),
            Op::FromBits => map1(float, mask, i.read(a), N::from_bits),
            Op::Ldexp => slow(float, mask, (f.read(a), i.read(b)), |(a, b)| a.ldexp(b)),
            Op::Select => match instr.dst.file {
                File::Float if N::DECIDED => {
                    inlined!(map3(float, mask, (t.read(a), f.read(b), f.read(c))), |t, a, b| N::select(t, a, b))
                }
                File::Float => choose(float, mask, t.read(a), (f.read(b), f.read(c))),
                File::Int => map3(int, mask, (t.read(a), i.read(b), i.read(c)), N::Int::select),
                File::Truth => map3(truth, mask, (t.read(a), t.read(b), t.read(c)), N::Truth::select),
            },
            Op::Int(function) => known!(
                IntBinary,
                function,
                [Add Sub Mul And Or Xor ShiftLeft ShiftRight],
                |KNOWN| inlined!(map2(int, mask, (i.read(a), i.read(b))), |a: N::Int, b| a.binary(KNOWN, b, signed)),
                slow(int, mask, (i.read(a), i.read(b)), |(a, b)| a.binary(function, b, signed))
            ),
            Op::IntUnary(function) => slow(int, mask, i.read(a), |a| a.unary(function, signed)),
            Op::Reread => inlined!(map1(int, mask, i.read(a)), |x: N::Int| x.reread(signed)),
            Op::IntLess => inlined!(map2(truth, mask, (i.read(a), i.read(b))), |a: N::Int, b| a.less(b, signed)),
            Op::IntEqual => inlined!(map2(truth, mask, (i.read(a), i.read(b))), |a: N::Int, b| a.equal(b)),
            Op::And => inlined!(map2(truth, mask, (t.read(a), t.read(b))), |a: N::Truth, b| a.and(b)),
            Op::Or => inlined!(map2(truth, mask, (t.read(a), t.read(b))), |a: N::Truth, b| a.or(b)),
            Op::Same => inlined!(map2(truth, mask, (t.read(a), t.read(b))), |a: N::Truth, b| a.equal(b)),
            Op::Not => inlined!(map1(truth, mask, t.read(a)), |a: N::Truth| a.not()),
            Op::Gather => {
                let table = &code.tables[instr.table as usize];
                let index = i.read(a);
                match instr.dst.file {
                    File::Float => {
                        pick(float, mask, index, table.len(), |at, lane| f.read(table[at]).at(lane), N::join)
                    }
                    File::Int => {
                        pick(int, mask, index, table.len(), |at, lane| i.read(table[at]).at(lane), N::Int::join)
                    }
                    File::Truth => {
                        pick(truth, mask, index, table.len(), |at, lane| t.read(table[at]).at(lane), N::Truth::join);
                    }
                }
            }
            Op::Sample => return self.sample(&code.lookups[instr.table as usize], images, mask),
            Op::Fetch => return self.fetch(&code.lookups[instr.table as usize], images, mask),
            Op::Derivative(along_y) => {
                let (a, step) = (f.read(a), if along_y { 2 } else { 1 });
                for lane in 0..LANES {
                    put(float, lane, a.at(lane | step).sub(a.at(lane & !step)));
                }
            }
        }
        let all = !instr.masked || mask == whole;
        match instr.dst.file {
            _ if instr.op == Op::Nop => {}
            File::Float => self.floats.settle(instr.dst, mask, all),
            File::Int => self.ints.settle(instr.dst, mask, all),
            File::Truth => self.truths.settle(instr.dst, mask, all),
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

/// One of a table, or what is any of those that an undecided index may mean.
fn pick<I: Integer, T: Packed>(
    out: &mut Row<T>,
    mask: u64,
    index: Operand<'_, I>,
    count: usize,
    value: impl Fn(usize, usize) -> T,
    join: fn(T, T) -> T,
) {
    each(mask, |lane| {
        let (first, last) = index.at(lane).index(count);
        put(out, lane, (first + 1..=last).fold(value(first, lane), |all, at| join(all, value(at, lane))));
    });
}
