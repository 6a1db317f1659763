#include "common/descriptor/network.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/dnn.hpp>
#include <set>

#include "descriptor/onnx.pb.h"

namespace headframe {

struct Network::Runtime {
  std::mutex mutex;
  cv::dnn::Net net;
  std::vector<cv::String> outputs;
};

namespace {

tl::unexpected<Error> bad(const std::string& name, const std::string& what) {
  return failure(ErrorCode::bad_input, name + ": " + what);
}

constexpr std::size_t most_bytes = 512U << 20U;

/// Disables OpenCV's log to standard error; the exception contains the same.
class Silence {
 public:
  Silence() : before_(cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT)) {}
  ~Silence() { cv::utils::logging::setLogLevel(before_); }
  Silence(const Silence&) = delete;
  Silence& operator=(const Silence&) = delete;

 private:
  cv::utils::logging::LogLevel before_;
};

/// Shortens OpenCV's message of many lines with source code to the innermost part, which says what is wrong.
std::string words_of(const cv::Exception& e) {
  std::string words = e.err.empty() ? e.what() : e.err;
  const auto stop = words.find_last_not_of("\n> ");
  words.resize(stop == std::string::npos ? 0 : stop + 1);
  if (const auto last = words.rfind("error: "); last != std::string::npos) words.erase(0, last + 7);
  std::replace(words.begin(), words.end(), '\n', ' ');
  return words;
}

Result<Network::Shape> shape_of(const onnx::Graph& graph, const std::string& name) {
  std::set<std::string> weights;
  for (const auto& w : graph.initializer()) weights.insert(w.name());
  const onnx::Value* image = nullptr;
  for (const auto& input : graph.input()) {
    if (weights.contains(input.name())) continue;
    if (image) return bad(name, "it has several inputs; a network here takes one image");
    image = &input;
  }
  if (!image) return bad(name, "it has no input");
  const auto& dimensions = image->type().tensor().shape().dimension();
  std::array<std::size_t, 4> sizes{};
  std::string text;
  for (int i = 0; i < dimensions.size(); ++i) {
    constexpr std::int64_t most = 65536;
    const auto& d = dimensions[i];
    text.append(i == 0 ? "" : "x").append(d.has_value() ? std::to_string(d.value()) : "?");
    if (i < 4 && d.value() > 0 && d.value() <= most)
      sizes.at(static_cast<std::size_t>(i)) = static_cast<std::size_t>(d.value());
  }
  const bool one = sizes[0] == 1 || (dimensions.size() == 4 && !dimensions[0].has_value());
  if (dimensions.size() != 4 || !one || sizes[1] * sizes[2] * sizes[3] == 0)
    return bad(name, "its input '" + image->name() + "' is " + (text.empty() ? "of no shape" : text) +
                         ", and must be one image of a fixed size: 1 x channels x rows x columns");
  return Network::Shape{sizes[1], sizes[2], sizes[3]};
}

std::vector<cv::Mat> forward(cv::dnn::Net& net, const Network::Shape& shape, const std::vector<float>& image,
                             const std::vector<cv::String>& outputs) {
  const std::array<int, 4> sizes{1, static_cast<int>(shape.channels), static_cast<int>(shape.rows),
                                 static_cast<int>(shape.columns)};
  // OpenCV has no constant header; setInput() copies.
  net.setInput(cv::Mat(4, sizes.data(), CV_32F, const_cast<float*>(image.data())));
  std::vector<cv::Mat> out;
  net.forward(out, outputs);
  return out;
}

}  // namespace

Result<Network> Network::from_bytes(std::string_view onnx, const std::string& name) {
  onnx::Model model;
  if (onnx.size() > most_bytes) return bad(name, "larger than 512 MiB");
  if (!model.ParsePartialFromArray(onnx.data(), static_cast<int>(onnx.size())) || !model.has_graph() ||
      model.graph().output().empty())
    return bad(name, "no ONNX network, or one that was cut short");
  const auto shape = shape_of(model.graph(), name);
  if (!shape) return tl::unexpected(shape.error());
  const Silence silence;
  try {
    Network network(name, std::make_unique<Runtime>());
    network.input_ = *shape;
    Runtime& runtime = *network.runtime_;
    runtime.net = cv::dnn::readNetFromONNX(onnx.data(), onnx.size());
    for (const auto& output : model.graph().output()) runtime.outputs.push_back(output.name());
    const auto trial = forward(runtime.net, *shape, std::vector<float>(shape->size()), runtime.outputs);
    for (std::size_t i = 0; i < trial.size(); ++i) network.outputs_.push_back({runtime.outputs[i], trial[i].total()});
    return network;
  } catch (const cv::Exception& e) {
    return bad(name, "can not be run here: " + words_of(e));
  } catch (const std::exception& e) {
    return bad(name, std::string("can not be run here: ") + e.what());
  }
}

Result<std::vector<std::vector<float>>> Network::run(const std::vector<float>& image) const {
  if (image.size() != input_.size())
    return bad(name_, "an image of " + std::to_string(image.size()) + " values, and it takes " + to_string(input_));
  std::vector<std::vector<float>> values;
  values.reserve(outputs_.size());
  try {
    const std::lock_guard lock(runtime_->mutex);
    for (const cv::Mat& out : forward(runtime_->net, input_, image, runtime_->outputs)) {
      if (out.type() != CV_32F) return bad(name_, "it gives values that are not 32 bit floats");
      values.emplace_back(out.begin<float>(), out.end<float>());
    }
  } catch (const cv::Exception& e) {
    return bad(name_, words_of(e));
  }
  for (const auto& of_output : values)
    if (!std::all_of(of_output.begin(), of_output.end(), [](float v) { return std::isfinite(v); }))
      return bad(name_, "it gives a value that is not finite for this scan");
  return values;
}

Network::Network(std::string name, std::unique_ptr<Runtime> runtime)
    : name_(std::move(name)), runtime_(std::move(runtime)) {}
Network::Network(Network&&) noexcept = default;
Network& Network::operator=(Network&&) noexcept = default;
Network::~Network() = default;

}  // namespace headframe
