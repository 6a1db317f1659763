#pragma once
// Spectra of two real grids that were transformed at once, and their correlation.

#include "server/place/fft2.hpp"

namespace headframe {

/// The spectra of two real n x n grids, walls and free ground.
struct Spectrum {
  explicit Spectrum(std::size_t n) : wall(n * n), free(n * n) {}
  ComplexGrid wall, free;
};

/// From the transform of a grid with the walls as real and the free ground as imaginary part.
void take_apart(const ComplexGrid& packed, std::size_t n, Spectrum& out);

/// Of the grids turned by a right angle.
void turn(const Spectrum& grids, std::size_t n, Spectrum& out);

/// a times the conjugate of b, summed over walls and free ground, for b and for b turned by a right angle: the inverse
/// transform has the correlation with the first as real, that with the second as imaginary part. With `half_a_turn`
/// both are turned by another two right angles.
void correlate(const Spectrum& a, const Spectrum& b, const Spectrum& b_turned, bool half_a_turn, ComplexGrid& product);

}  // namespace headframe
