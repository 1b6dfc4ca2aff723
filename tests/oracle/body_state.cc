#include "tests/oracle/body_state.h"

namespace godobject::oracle {

std::vector<BodyState> body_states(const ScalarVector& y) {
  std::vector<BodyState> states(static_cast<std::size_t>(y.size() / state_size));
  for (std::size_t i = 0; i < states.size(); ++i) {
    const Eigen::Matrix<Scalar, state_size, 1> x = y.segment<state_size>(offset_of(i));
    states[i] = {x.segment<3>(0), ScalarQuaternion(x[3], x[4], x[5], x[6]), x.segment<3>(7),
                 x.segment<3>(10)};
  }
  return states;
}

ScalarVector pack(const std::vector<BodyState>& states) {
  ScalarVector y(offset_of(states.size()));
  for (std::size_t i = 0; i < states.size(); ++i) {
    y.segment<state_size>(offset_of(i)) << states[i].p, wxyz(states[i].q), states[i].v, states[i].w;
  }
  return y;
}

ScalarVector pack(const std::vector<RigidState>& states) {
  std::vector<BodyState> copies;
  for (const RigidState& x : states) {
    copies.push_back({x.p.cast<Scalar>(), x.q.cast<Scalar>(), x.v.cast<Scalar>(), x.w.cast<Scalar>()});
  }
  ScalarVector y = pack(copies);
  normalise(y);
  return y;
}

std::vector<RigidState> unpack(const ScalarVector& y) {
  std::vector<RigidState> states;
  for (const BodyState& x : body_states(y)) {
    states.push_back(
        {x.p.cast<double>(), x.q.normalized().cast<double>(), x.v.cast<double>(), x.w.cast<double>()});
  }
  return states;
}

void normalise(ScalarVector& y) {
  for (Eigen::Index q = 3; q < y.size(); q += state_size) y.segment<4>(q).normalize();
}

}  // namespace godobject::oracle
