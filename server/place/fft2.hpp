#pragma once

#include <boost/align/aligned_allocator.hpp>
#include <cstddef>
#include <vector>

namespace headframe {

/// Begins at a cache line, so that vector registers are loaded from one line each.
using Floats = std::vector<float, boost::alignment::aligned_allocator<float, 64>>;

/// Complex numbers of a row-major grid, with real and imaginary parts separate so that rows can be vectorised.
struct ComplexGrid {
  explicit ComplexGrid(std::size_t size = 0) : re(size), im(size) {}
  Floats re, im;
};

/// Complex 2D FFT of n x n grids, n = 16 * 2^i or 16 * 3 * 2^i, unscaled. Our own, because a wall search needs 135 of
/// them for each pair of levels, which took most of a merge's time with KissFFT, and FFTW is GPL. Not thread safe: it
/// holds scratch memory.
class Fft2 {
 public:
  explicit Fft2(std::size_t n);
  /// In place.
  void forward(ComplexGrid& grid) { transform(grid); }
  void inverse(ComplexGrid& spectrum);

  static std::size_t size_for(std::size_t cells);  // the smallest n that is not smaller

 private:
  void transform(ComplexGrid& grid);
  void columns_transposed(const ComplexGrid& in, ComplexGrid& out);

  std::size_t n_;
  std::vector<float> cos_, sin_;  // of -2 pi k / n
  ComplexGrid other_, from_, to_;
};

}  // namespace headframe
