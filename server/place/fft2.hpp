#pragma once

#include <kissfft/kiss_fftnd.h>

#include <complex>
#include <memory>
#include <type_traits>
#include <vector>

namespace headframe {

/// Complex 2D transform of row-major grids; the inverse is not scaled. Not thread safe: the plan holds scratch memory.
class Fft2 {
 public:
  using Complex = std::complex<float>;
  enum class Way { forward, inverse };

  Fft2(int rows, int columns, Way way) {
    const int dims[2] = {rows, columns};
    plan_.reset(kiss_fftnd_alloc(dims, 2, way == Way::inverse ? 1 : 0, nullptr, nullptr));
  }

  void run(const std::vector<Complex>& in, std::vector<Complex>& out) const {
    static_assert(sizeof(Complex) == sizeof(kiss_fft_cpx));
    kiss_fftnd(plan_.get(), reinterpret_cast<const kiss_fft_cpx*>(in.data()),
               reinterpret_cast<kiss_fft_cpx*>(out.data()));
  }

  /// The smallest size of at least n cells that is quick to transform.
  static int quick_size(int n) { return kiss_fft_next_fast_size(n); }

 private:
  struct Free {
    void operator()(kiss_fftnd_cfg plan) const { kiss_fft_free(plan); }
  };
  std::unique_ptr<std::remove_pointer_t<kiss_fftnd_cfg>, Free> plan_;
};

}  // namespace headframe
