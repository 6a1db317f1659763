#include "server/registration/normal_equations.hpp"

#include <algorithm>
#include <cmath>

#include "server/support/parallel.hpp"

namespace headframe {
namespace {

using Lanes = Eigen::Array4f;
constexpr std::size_t lanes = 4;
constexpr float least_squared_dot = 0.25F;  // of the normals: 60 deg

using Vector = std::array<Lanes, 3>;
using Symmetric = std::array<Lanes, 6>;  // xx, xy, xz, yy, yz, zz
constexpr std::array<std::array<std::size_t, 3>, 3> at{{{0, 1, 2}, {1, 3, 4}, {2, 4, 5}}};

template <std::size_t N, class Rows>
std::array<Lanes, N> load(const Rows& rows, std::size_t first) {
  std::array<Lanes, N> out;
  for (std::size_t k = 0; k < N; ++k) out[k] = Eigen::Map<const Lanes, Eigen::Aligned16>(&rows[k][first]);
  return out;
}

Vector product(const Symmetric& M, const Vector& v) {
  Vector out;
  for (std::size_t r = 0; r < 3; ++r) out[r] = M[at[r][0]] * v[0] + M[at[r][1]] * v[1] + M[at[r][2]] * v[2];
  return out;
}

Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Lanes dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

Symmetric inverse(const Symmetric& C) {
  Symmetric M;
  M[0] = C[3] * C[5] - C[4] * C[4];
  M[1] = C[2] * C[4] - C[1] * C[5];
  M[2] = C[1] * C[4] - C[2] * C[3];
  M[3] = C[0] * C[5] - C[2] * C[2];
  M[4] = C[1] * C[2] - C[0] * C[4];
  M[5] = C[0] * C[3] - C[1] * C[1];
  const Lanes scale = 1 / (C[0] * M[0] + C[1] * M[1] + C[2] * M[2]);
  for (Lanes& m : M) m *= scale;
  return M;
}

/// (C_t + C_s)^-1 for C = I - flat N; flat is 1 - epsilon.
Symmetric information(const Symmetric& N_t, const Vector& n_s, float flat) {
  Symmetric C;
  for (std::size_t r = 0; r < 3; ++r)
    for (std::size_t c = r; c < 3; ++c) C[at[r][c]] = (r == c ? 2.0F : 0.0F) - flat * (N_t[at[r][c]] + n_s[r] * n_s[c]);
  return inverse(C);
}

/// Sums over lanes of the upper triangle of H by blocks: rotation, mixed (q x M, all nine), translation.
struct Sums {
  Symmetric rotation, translation, normals, levers;
  std::array<Vector, 3> mixed;
  Vector turn, push;
  Lanes inliers, squared_plane;

  Sums() {
    const auto zero = [](auto& array) {
      for (Lanes& x : array) x.setZero();
    };
    zero(rotation), zero(translation), zero(normals), zero(levers), zero(turn), zero(push);
    for (Vector& row : mixed) zero(row);
    inliers.setZero();
    squared_plane.setZero();
  }

  /// J = [-[q]x I], so H = w [[q]x M [q]x^T, [q]x M; ., M] and b = w [q x M e; M e].
  void add(const Vector& q, const Vector& e, const Symmetric& N_t, const Vector& n_s, const Lanes& used, float kernel,
           float flat) {
    Symmetric M = information(N_t, n_s, flat);
    const Vector N_n = product(N_t, n_s), N_e = product(N_t, e);
    const Lanes agree = (dot(n_s, N_n) >= least_squared_dot).select(used, Lanes::Zero());
    const Lanes ratio = kernel / (kernel + dot(e, product(M, e)));
    const Lanes weight = agree * ratio * ratio;
    for (Lanes& m : M) m *= weight;
    const Vector force = product(M, e), torque = cross(q, force);
    std::array<Vector, 3> A;  // columns of [q]x M
    for (std::size_t c = 0; c < 3; ++c) A[c] = cross(q, {M[at[0][c]], M[at[1][c]], M[at[2][c]]});
    for (std::size_t r = 0; r < 3; ++r) {
      turn[r] += torque[r];
      push[r] += force[r];
      const Vector row = cross(q, {A[0][r], A[1][r], A[2][r]});  // row r of A [q]x^T
      for (std::size_t c = r; c < 3; ++c) rotation[at[r][c]] += row[c];
      for (std::size_t c = 0; c < 3; ++c) mixed[r][c] += A[c][r];
      for (std::size_t c = r; c < 3; ++c) levers[at[r][c]] += agree * q[r] * q[c];
    }
    for (std::size_t k = 0; k < 6; ++k) {
      translation[k] += M[k];
      normals[k] += agree * N_t[k];
    }
    inliers += agree;
    squared_plane += agree * dot(e, N_e);
  }

  NormalEquations total() const {
    NormalEquations out;
    for (std::size_t r = 0; r < 3; ++r) {
      const auto i = static_cast<Eigen::Index>(r);
      out.b[i] = turn[r].sum();
      out.b[i + 3] = push[r].sum();
      for (std::size_t c = 0; c < 3; ++c) {
        const auto j = static_cast<Eigen::Index>(c);
        out.H(i, j) = rotation[at[r][c]].sum();
        out.H(i + 3, j + 3) = translation[at[r][c]].sum();
        out.H(i, j + 3) = out.H(j + 3, i) = mixed[r][c].sum();
        out.normals(i, j) = normals[at[r][c]].sum();
        out.levers(i, j) = levers[at[r][c]].sum();
      }
    }
    out.inliers = inliers.sum();
    out.squared_plane_m2 = squared_plane.sum();
    return out;
  }
};

}  // namespace

NormalEquations& NormalEquations::operator+=(const NormalEquations& o) {
  H += o.H;
  b += o.b;
  inliers += o.inliers;
  squared_plane_m2 += o.squared_plane_m2;
  normals += o.normals;
  levers += o.levers;
  return *this;
}

Symmetric3f outer(const Eigen::Vector3f& n) {
  return {n.x() * n.x(), n.x() * n.y(), n.x() * n.z(), n.y() * n.y(), n.y() * n.z(), n.z() * n.z()};
}

NormalEquations FactorBlock::sum(const FactorModel& model, double reach_m) {
  const auto kernel = static_cast<float>(std::pow(model.kernel_share * reach_m, 2) / (2 * model.plane_epsilon));
  const auto flat = static_cast<float>(1 - model.plane_epsilon);
  const std::size_t full = (count_ + lanes - 1) / lanes * lanes;
  for (std::size_t i = count_; i < full; ++i) {  // finite fillers, not used
    for (std::size_t a = 0; a < 3; ++a) q_[a][i] = e_[a][i] = n_s_[a][i] = 0;
    for (std::size_t k = 0; k < 6; ++k) N_t_[k][i] = 0;
  }
  Sums sums;
  for (std::size_t i = 0; i < full; i += lanes) {
    Lanes used = Lanes::Ones();
    for (std::size_t l = count_ - std::min(count_, i); l < lanes; ++l) used[static_cast<Eigen::Index>(l)] = 0;
    sums.add(load<3>(q_, i), load<3>(e_, i), load<6>(N_t_, i), load<3>(n_s_, i), used, kernel, flat);
  }
  return sums.total();
}

void FactorBlock::append_distances(std::vector<float>& distances_m) const {
  for (std::size_t i = 0; i < count_; ++i) {
    const auto vector = [i](const auto& rows) { return Eigen::Vector3f(rows[0][i], rows[1][i], rows[2][i]); };
    Eigen::Matrix3f N;
    for (std::size_t r = 0; r < 3; ++r)
      for (std::size_t c = 0; c < 3; ++c)
        N(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(c)) = N_t_[at[r][c]][i];
    const Eigen::Vector3f n = vector(n_s_), e = vector(e_);
    if (n.dot(N * n) >= least_squared_dot) distances_m.push_back(std::sqrt(std::max(0.0F, e.dot(N * e))));
  }
}

NormalEquations sum_factors(std::size_t count, int threads, const FactorModel& model, double reach_m,
                            const std::function<void(std::size_t begin, std::size_t end, FactorBlock&)>& add,
                            std::vector<float>* distances_m) {
  constexpr std::size_t size = FactorBlock::capacity;
  std::vector<NormalEquations> sums((count + size - 1) / size);
  std::vector<std::vector<float>> distances(distances_m ? sums.size() : 0);
  for_blocks(count, size, threads, [&](std::size_t begin, std::size_t end, std::size_t block) {
    FactorBlock factors;
    add(begin, end, factors);
    sums[block] = factors.sum(model, reach_m);
    if (distances_m) factors.append_distances(distances[block]);
  });
  NormalEquations total;
  for (const NormalEquations& s : sums) total += s;
  if (distances_m)
    for (const auto& d : distances) distances_m->insert(distances_m->end(), d.begin(), d.end());
  return total;
}

}  // namespace headframe
