#include "server/place/fft2.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "server/support/wide.hpp"

namespace headframe {
namespace {

constexpr std::size_t strip = 16;  // columns at a time: whole cache lines, and all stages stay in the cache

struct Run {
  const float* re;
  const float* im;
};
struct OutRun {
  float* re;
  float* im;
};
struct Twiddle {
  float c, s;
};

// Butterflies on runs of `count` numbers that share their twiddles (Stockham, decimation in frequency). Outputs lie
// `count` apart. Inlined into transform_strip, so that its clones vectorise them.

[[gnu::always_inline]] inline void butterfly4(Run a, Run b, Run c, Run d, OutRun y, std::size_t count, Twiddle w1,
                                              Twiddle w2, Twiddle w3) {
  float* __restrict y0r = y.re, * __restrict y0i = y.im;
  float* __restrict y1r = y.re + count, * __restrict y1i = y.im + count;
  float* __restrict y2r = y.re + 2 * count, * __restrict y2i = y.im + 2 * count;
  float* __restrict y3r = y.re + 3 * count, * __restrict y3i = y.im + 3 * count;
  HEADFRAME_INDEPENDENT for (std::size_t k = 0; k < count; ++k) {
    const float acr = a.re[k] + c.re[k], aci = a.im[k] + c.im[k], amr = a.re[k] - c.re[k], ami = a.im[k] - c.im[k];
    const float bdr = b.re[k] + d.re[k], bdi = b.im[k] + d.im[k], bmr = b.re[k] - d.re[k], bmi = b.im[k] - d.im[k];
    y0r[k] = acr + bdr;
    y0i[k] = aci + bdi;
    const float t1r = amr + bmi, t1i = ami - bmr, t2r = acr - bdr, t2i = aci - bdi, t3r = amr - bmi, t3i = ami + bmr;
    y1r[k] = t1r * w1.c - t1i * w1.s;
    y1i[k] = t1r * w1.s + t1i * w1.c;
    y2r[k] = t2r * w2.c - t2i * w2.s;
    y2i[k] = t2r * w2.s + t2i * w2.c;
    y3r[k] = t3r * w3.c - t3i * w3.s;
    y3i[k] = t3r * w3.s + t3i * w3.c;
  }
}

[[gnu::always_inline]] inline void butterfly3(Run a, Run b, Run c, OutRun y, std::size_t count, Twiddle w1,
                                              Twiddle w2) {
  constexpr float half_root3 = std::numbers::sqrt3_v<float> / 2;
  float* __restrict y0r = y.re, * __restrict y0i = y.im;
  float* __restrict y1r = y.re + count, * __restrict y1i = y.im + count;
  float* __restrict y2r = y.re + 2 * count, * __restrict y2i = y.im + 2 * count;
  HEADFRAME_INDEPENDENT for (std::size_t k = 0; k < count; ++k) {
    const float bcr = b.re[k] + c.re[k], bci = b.im[k] + c.im[k];
    const float ur = half_root3 * (b.re[k] - c.re[k]), ui = half_root3 * (b.im[k] - c.im[k]);
    const float tr = a.re[k] - 0.5F * bcr, ti = a.im[k] - 0.5F * bci;
    y0r[k] = a.re[k] + bcr;
    y0i[k] = a.im[k] + bci;
    y1r[k] = (tr + ui) * w1.c - (ti - ur) * w1.s;
    y1i[k] = (tr + ui) * w1.s + (ti - ur) * w1.c;
    y2r[k] = (tr - ui) * w2.c - (ti + ur) * w2.s;
    y2i[k] = (tr - ui) * w2.s + (ti + ur) * w2.c;
  }
}

[[gnu::always_inline]] inline void butterfly2(Run a, Run b, OutRun y, std::size_t count) {
  float* __restrict y0r = y.re, * __restrict y0i = y.im;
  float* __restrict y1r = y.re + count, * __restrict y1i = y.im + count;
  HEADFRAME_INDEPENDENT for (std::size_t k = 0; k < count; ++k) {
    y0r[k] = a.re[k] + b.re[k];
    y0i[k] = a.im[k] + b.im[k];
    y1r[k] = a.re[k] - b.re[k];
    y1i[k] = a.im[k] - b.im[k];
  }
}

/// Runs all stages on a strip of columns of n numbers, alternating between two buffers. Returns the one with the
/// result.
HEADFRAME_WIDE ComplexGrid* transform_strip(ComplexGrid* from, ComplexGrid* to, std::size_t n, const float* cos,
                                            const float* sin) {
  std::size_t run = strip;
  for (std::size_t length = n; length > 1;) {
    const std::size_t radix = length % 4 == 0 ? 4 : length % 3 == 0 ? 3 : 2, part = length / radix, turn = n / length;
    const auto in = [&](std::size_t at) { return Run{from->re.data() + run * at, from->im.data() + run * at}; };
    const auto out = [&](std::size_t at) { return OutRun{to->re.data() + run * at, to->im.data() + run * at}; };
    const auto twiddle = [&](std::size_t k) { return Twiddle{cos[turn * k], sin[turn * k]}; };
    if (radix == 4)
      for (std::size_t p = 0; p < part; ++p)
        butterfly4(in(p), in(p + part), in(p + 2 * part), in(p + 3 * part), out(4 * p), run, twiddle(p), twiddle(2 * p),
                   twiddle(3 * p));
    else if (radix == 3)
      for (std::size_t p = 0; p < part; ++p)
        butterfly3(in(p), in(p + part), in(p + 2 * part), out(3 * p), run, twiddle(p), twiddle(2 * p));
    else  // the last stage: its twiddle is 1
      butterfly2(in(0), in(1), out(0), run);
    length = part;
    run *= radix;
    std::swap(from, to);
  }
  return from;
}

}  // namespace

Fft2::Fft2(std::size_t n) : n_(n), cos_(n), sin_(n), other_(n * n), from_(strip * n), to_(strip * n) {
  for (std::size_t k = 0; k < n; ++k) {
    const double angle = -2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(n);
    cos_[k] = static_cast<float>(std::cos(angle));
    sin_[k] = static_cast<float>(std::sin(angle));
  }
}

std::size_t Fft2::size_for(std::size_t cells) {
  std::size_t n = strip;
  while (n < cells) n *= 2;
  return n >= 4 * strip && n / 4 * 3 >= cells ? n / 4 * 3 : n;
}

/// Transforms along y and writes the result transposed: value (ky, x) to row x, column ky.
void Fft2::columns_transposed(const ComplexGrid& in, ComplexGrid& out) {
  for (std::size_t first = 0; first < n_; first += strip) {
    for (std::size_t y = 0; y < n_; ++y) {
      std::copy_n(&in.re[y * n_ + first], strip, &from_.re[y * strip]);
      std::copy_n(&in.im[y * n_ + first], strip, &from_.im[y * strip]);
    }
    const ComplexGrid& done = *transform_strip(&from_, &to_, n_, cos_.data(), sin_.data());
    // In tiles, because rows at a distance of a power of two would evict each other from the cache.
    for (std::size_t y = 0; y < n_; y += strip)
      for (std::size_t x = 0; x < strip; ++x)
        for (std::size_t k = y; k < y + strip; ++k) {
          out.re[(first + x) * n_ + k] = done.re[k * strip + x];
          out.im[(first + x) * n_ + k] = done.im[k * strip + x];
        }
  }
}

void Fft2::transform(ComplexGrid& grid) {
  columns_transposed(grid, other_);
  columns_transposed(other_, grid);
}

void Fft2::inverse(ComplexGrid& spectrum) {
  // The inverse is the forward transform with real and imaginary parts exchanged, before and after.
  std::swap(spectrum.re, spectrum.im);
  transform(spectrum);
  std::swap(spectrum.re, spectrum.im);
}

}  // namespace headframe
