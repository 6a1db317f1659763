#include "server/place/spectrum.hpp"

#include "server/support/wide.hpp"

namespace headframe {
namespace {

/// One row, from the rows of the packed spectrum with this and with the opposite frequency.
HEADFRAME_WIDE void take_row_apart(const float* re, const float* im, const float* opposite_re, const float* opposite_im,
                                   std::size_t n, float* wall_re, float* wall_im, float* free_re, float* free_im) {
  const auto at = [&](std::size_t x, std::size_t opposite) {
    wall_re[x] = (re[x] + opposite_re[opposite]) / 2;
    wall_im[x] = (im[x] - opposite_im[opposite]) / 2;
    free_re[x] = (im[x] + opposite_im[opposite]) / 2;
    free_im[x] = (opposite_re[opposite] - re[x]) / 2;
  };
  at(0, 0);
  HEADFRAME_INDEPENDENT for (std::size_t x = 1; x < n; ++x) at(x, n - x);
}

/// In tiles, because rows at a distance of a power of two would evict each other from the cache.
void turn(const Floats& grid, std::size_t n, Floats& out) {
  constexpr std::size_t tile = 16;  // divides the sizes of Fft2
  for (std::size_t first_y = 0; first_y < n; first_y += tile)
    for (std::size_t first_x = 0; first_x < n; first_x += tile)
      for (std::size_t x = first_x; x < first_x + tile; ++x) {
        const float* from = &grid[(n - x) % n * n];
        for (std::size_t y = first_y; y < first_y + tile; ++y) out[y * n + x] = from[y];
      }
}

/// With sign -1 b is its complex conjugate.
HEADFRAME_WIDE void multiply(const Spectrum& a, const Spectrum& b, const Spectrum& turned, float sign,
                             ComplexGrid& product) {
  const float *awr = a.wall.re.data(), *awi = a.wall.im.data(), *afr = a.free.re.data(), *afi = a.free.im.data();
  const float *bwr = b.wall.re.data(), *bwi = b.wall.im.data(), *bfr = b.free.re.data(), *bfi = b.free.im.data();
  const float *twr = turned.wall.re.data(), *twi = turned.wall.im.data();
  const float *tfr = turned.free.re.data(), *tfi = turned.free.im.data();
  float *re = product.re.data(), *im = product.im.data();
  const std::size_t count = product.re.size();
  HEADFRAME_INDEPENDENT for (std::size_t i = 0; i < count; ++i) {
    const float wi = sign * bwi[i], fi = sign * bfi[i], ti = sign * twi[i], ui = sign * tfi[i];
    const float re_b = awr[i] * bwr[i] + awi[i] * wi + afr[i] * bfr[i] + afi[i] * fi;
    const float im_b = awi[i] * bwr[i] - awr[i] * wi + afi[i] * bfr[i] - afr[i] * fi;
    const float re_t = awr[i] * twr[i] + awi[i] * ti + afr[i] * tfr[i] + afi[i] * ui;
    const float im_t = awi[i] * twr[i] - awr[i] * ti + afi[i] * tfr[i] - afr[i] * ui;
    re[i] = re_b - im_t;
    im[i] = im_b + re_t;
  }
}

}  // namespace

void take_apart(const ComplexGrid& packed, std::size_t n, Spectrum& out) {
  for (std::size_t y = 0; y < n; ++y) {
    const std::size_t row = y * n, opposite = (n - y) % n * n;
    take_row_apart(&packed.re[row], &packed.im[row], &packed.re[opposite], &packed.im[opposite], n, &out.wall.re[row],
                   &out.wall.im[row], &out.free.re[row], &out.free.im[row]);
  }
}

/// A grid turned by a right angle has at (kx, ky) what the grid itself has at (ky, -kx).
void turn(const Spectrum& grids, std::size_t n, Spectrum& out) {
  turn(grids.wall.re, n, out.wall.re);
  turn(grids.wall.im, n, out.wall.im);
  turn(grids.free.re, n, out.free.re);
  turn(grids.free.im, n, out.free.im);
}

/// Half a turn is the complex conjugate, because the grids are real.
void correlate(const Spectrum& a, const Spectrum& b, const Spectrum& b_turned, bool half_a_turn, ComplexGrid& product) {
  multiply(a, b, b_turned, half_a_turn ? -1.0F : 1.0F, product);
}

}  // namespace headframe
