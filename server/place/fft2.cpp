#include "server/place/fft2.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

// The same results with and without: AVX2 has no fused operations.
#if defined(__x86_64__) && defined(__gnu_linux__) && defined(__GNUC__) && !defined(__clang__)
#define HEADFRAME_WIDE __attribute__((target_clones("avx2", "default")))
#else
#define HEADFRAME_WIDE
#endif

namespace headframe {
namespace {

constexpr std::size_t strip = 16;

struct Rows {
  const float* re;
  const float* im;
};
struct OutRows {
  float* re;
  float* im;
};
struct Twiddle {
  float c, s;
};

/// One butterfly of radix 4 on runs of `count` numbers each (Stockham, decimation in frequency).
HEADFRAME_WIDE void butterfly4(Rows a, Rows b, Rows c, Rows d, OutRows y, std::size_t step, std::size_t count,
                               Twiddle w1, Twiddle w2, Twiddle w3) {
  const float *ar = a.re, *ai = a.im, *br = b.re, *bi = b.im, *cr = c.re, *ci = c.im, *dr = d.re, *di = d.im;
  float* __restrict y0r = y.re, * __restrict y0i = y.im;
  float* __restrict y1r = y.re + step, * __restrict y1i = y.im + step;
  float* __restrict y2r = y.re + 2 * step, * __restrict y2i = y.im + 2 * step;
  float* __restrict y3r = y.re + 3 * step, * __restrict y3i = y.im + 3 * step;
  for (std::size_t k = 0; k < count; ++k) {
    const float acr = ar[k] + cr[k], aci = ai[k] + ci[k], amr = ar[k] - cr[k], ami = ai[k] - ci[k];
    const float bdr = br[k] + dr[k], bdi = bi[k] + di[k], bmr = br[k] - dr[k], bmi = bi[k] - di[k];
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

HEADFRAME_WIDE void butterfly2(Rows a, Rows b, OutRows y, std::size_t step, std::size_t count) {
  float* __restrict y0r = y.re, * __restrict y0i = y.im;
  float* __restrict y1r = y.re + step, * __restrict y1i = y.im + step;
  for (std::size_t k = 0; k < count; ++k) {
    y0r[k] = a.re[k] + b.re[k];
    y0i[k] = a.im[k] + b.im[k];
    y1r[k] = a.re[k] - b.re[k];
    y1i[k] = a.im[k] - b.im[k];
  }
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
  std::size_t n = 4;
  while (n < cells) n *= 2;
  return n;
}

/// Transforms along y and writes the result turned over: value (ky, x) to row x, column ky. A strip of columns at a
/// time stays in the cache through all stages.
void Fft2::columns_transposed(const ComplexGrid& in, ComplexGrid& out) {
  for (std::size_t first = 0; first < n_; first += strip) {
    const std::size_t width = std::min(strip, n_ - first);
    for (std::size_t y = 0; y < n_; ++y) {
      std::copy_n(&in.re[y * n_ + first], width, &from_.re[y * width]);
      std::copy_n(&in.im[y * n_ + first], width, &from_.im[y * width]);
    }
    columns(width);
    for (std::size_t y = 0; y < n_; ++y)
      for (std::size_t x = 0; x < width; ++x) {
        out.re[(first + x) * n_ + y] = from_.re[y * width + x];
        out.im[(first + x) * n_ + y] = from_.im[y * width + x];
      }
  }
}

/// Stockham stages on the strip in from_.
void Fft2::columns(std::size_t width) {
  std::size_t run = width;  // numbers that share a twiddle
  for (std::size_t length = n_; length > 1;) {
    const auto in = [&](std::size_t at) { return Rows{from_.re.data() + at, from_.im.data() + at}; };
    const auto out = [&](std::size_t at) { return OutRows{to_.re.data() + at, to_.im.data() + at}; };
    if (length % 4 == 0) {
      const std::size_t quarter = length / 4, turn = n_ / length;
      const auto twiddle = [&](std::size_t k) { return Twiddle{cos_[k % n_], sin_[k % n_]}; };
      for (std::size_t p = 0; p < quarter; ++p)
        butterfly4(in(run * p), in(run * (p + quarter)), in(run * (p + 2 * quarter)), in(run * (p + 3 * quarter)),
                   out(run * 4 * p), run, run, twiddle(turn * p), twiddle(2 * turn * p), twiddle(3 * turn * p));
      length /= 4;
      run *= 4;
    } else {  // the last stage of an odd power of two: its twiddle is 1
      butterfly2(in(0), in(run), out(0), run, run);
      length /= 2;
      run *= 2;
    }
    std::swap(from_, to_);
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
