#include "server/support/printable_log.hpp"

#include <spdlog/pattern_formatter.h>

#include "common/printable.hpp"

namespace headframe {
namespace {

class PrintableFormatter : public spdlog::formatter {
 public:
  void format(const spdlog::details::log_msg& message, spdlog::memory_buf_t& out) override {
    const std::string text = printable({message.payload.data(), message.payload.size()});
    spdlog::details::log_msg safe = message;
    safe.payload = text;
    lines_.format(safe, out);
    message.color_range_start = safe.color_range_start;
    message.color_range_end = safe.color_range_end;
  }
  std::unique_ptr<formatter> clone() const override { return std::make_unique<PrintableFormatter>(); }

 private:
  spdlog::pattern_formatter lines_;
};

}  // namespace

std::unique_ptr<spdlog::formatter> printable_log() { return std::make_unique<PrintableFormatter>(); }

}  // namespace headframe
