#include "tests/bench/calibration.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "server/merge/merge_config.hpp"
#include "server/picture/canvas.hpp"

namespace headframe::bench {

void Calibration::add(double probability, bool right, const std::string& mine) {
  const auto last = static_cast<double>(bins_.size() - 1);
  Bin& bin = bins_.at(static_cast<std::size_t>(std::clamp(std::floor(10 * probability), 0.0, last)));
  ++bin.placements;
  bin.right += right;
  bin.sum += probability;
  false_ += !right && probability >= MergeConfig{}.accept_probability;
  mines_.insert(mine);
}

int Calibration::total(int Bin::*count) const {
  int sum = 0;
  for (const Bin& bin : bins_) sum += bin.*count;
  return sum;
}

double Calibration::error() const {
  double sum = 0;
  for (const Bin& bin : bins_)
    if (bin.placements > 0) sum += bin.placements * std::abs(bin.share() - bin.mean());
  return sum / std::max(1, total(&Bin::placements));
}

nlohmann::json Calibration::json() const {
  return {{"ece", error()},
          {"placements", total(&Bin::placements)},
          {"right", total(&Bin::right)},
          {"false", false_},
          {"mines", mines_.size()}};
}

void Calibration::print() const {
  std::printf("  the verdict on %d placements in %zu mines, %d of them right: expected calibration error %.3f\n",
              total(&Bin::placements), mines_.size(), total(&Bin::right), error());
  for (const Bin& bin : bins_)
    if (bin.placements > 0)
      std::printf("    mean probability %.3f: %d of %d right\n", bin.mean(), bin.right, bin.placements);
}

Result<void> Calibration::draw(const std::filesystem::path& png) const {
  constexpr int side = 400, left = 50, top = 40;
  const picture::Colour ink = picture::Colour::Constant(0.9F), faint = picture::Colour::Constant(0.3F);
  picture::Canvas canvas(left + side + 60, top + side + 50, picture::Colour::Constant(0.08F));
  const auto at = [](double p, double share) {
    return Eigen::Vector2f(left + side * static_cast<float>(p), top + side * (1 - static_cast<float>(share)));
  };
  canvas.text(left, 12, "Right placements by the probability of the verdict", 1, ink);
  for (const double mark : {0.0, 0.5, 1.0}) {
    canvas.line(at(mark, 0), at(mark, 1), 1, faint);
    canvas.line(at(0, mark), at(1, mark), 1, faint);
    char text[8];
    std::snprintf(text, sizeof text, "%.1f", mark);
    canvas.text(static_cast<int>(at(mark, 0).x()) - 8, top + side + 8, text, 1, ink);
    canvas.text(left - 30, static_cast<int>(at(0, mark).y()) - 4, text, 1, ink);
  }
  canvas.line(at(0, 0), at(1, 1), 1, ink, 0.5F);  // where each is right as often as was said
  for (const Bin& bin : bins_) {
    if (bin.placements == 0) continue;
    const Eigen::Vector2f p = at(bin.mean(), bin.share());
    canvas.disc(p, 3 + 2 * std::log2(static_cast<float>(1 + bin.placements)) / 3, {0.3F, 0.8F, 0.4F});
    const std::string count = std::to_string(bin.right) + " of " + std::to_string(bin.placements);
    canvas.text(static_cast<int>(p.x()) + 8, static_cast<int>(p.y()) + (bin.share() > 0.5 ? 8 : -14), count, 1, ink);
  }
  return canvas.write_png(png);
}

}  // namespace headframe::bench
