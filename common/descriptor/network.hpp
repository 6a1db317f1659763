#pragma once
// A neural network from an ONNX file. The runtime is used only in network.cpp.

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.hpp"

namespace headframe {

/// One image in, one or more vectors out.
class Network {
 public:
  struct Shape {  // of the input, for one image
    std::size_t channels = 0, rows = 0, columns = 0;
    std::size_t size() const { return channels * rows * columns; }
    bool operator==(const Shape&) const = default;
  };
  struct Output {
    std::string name;
    std::size_t size = 0;  // values for one image
  };

  /// Reads the network and runs it once on zeros. name: used in messages. bad_input: not ONNX or truncated, not exactly
  /// one image as input, or an operation that is not supported; not_found: this build has no networks
  /// (HEADFRAME_NETWORKS).
  static Result<Network> from_bytes(std::string_view onnx, const std::string& name);
  /// The bytes of a file; not_found if it cannot be read.
  static Result<std::string> read(const std::filesystem::path& file);

  Network(Network&&) noexcept;
  Network& operator=(Network&&) noexcept;
  ~Network();

  const Shape& input() const { return input_; }
  const std::vector<Output>& outputs() const { return outputs_; }

  /// image: input().size() values, channel by channel, row by row. Returns the values of each output, in the order of
  /// outputs(). bad_input: another size, or an output that is not finite. Thread safe, but runs one image at a time;
  /// the runtime may use several threads for it.
  Result<std::vector<std::vector<float>>> run(const std::vector<float>& image) const;

 private:
  struct Runtime;
  Network(std::string name, std::unique_ptr<Runtime> runtime);

  std::string name_;
  Shape input_;
  std::vector<Output> outputs_;
  std::unique_ptr<Runtime> runtime_;
};

/// "2x16x256"
std::string to_string(const Network::Shape& shape);

}  // namespace headframe
