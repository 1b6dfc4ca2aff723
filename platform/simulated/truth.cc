#include "platform/simulated/truth.h"

namespace godobject {

SimulatedTruth::SimulatedTruth(const SceneConfig& scene, std::shared_ptr<const Hand> hand,
                               const SimLink* link)
    : hand_(std::move(hand)),
      link_(link),
      driven_(driven_bodies(scene)),
      handle_(driven_.size()),
      grips_bodies_(grips_bodies(scene)) {
  if (link_ == nullptr) return;
  const std::vector<std::optional<std::size_t>> by_handle = driven_by_handles(scene);
  for (std::size_t k = 0; k < by_handle.size(); ++k)
    if (by_handle[k]) handle_[*by_handle[k]] = k;
  joints_ = PrescribedSamples(scene);
}

void SimulatedTruth::start(const SceneConfig& scene, std::span<const BodySample> samples) {
  samples_.assign(samples.begin(), samples.end());
  std::string why_not;
  engine_ = make_engine(scene, samples_, why_not);
}

/// Returns the exact pose of the handle of this driven body; without a handle, the hand's target.
Target SimulatedTruth::target(std::size_t driven, double t) const noexcept {
  const std::size_t index = grips_bodies_ ? 0 : driven;
  if (handle_[index]) return link_->rig().handle(*handle_[index]);
  return hand_->target(index, t);
}

void SimulatedTruth::step(double t, std::span<const BodySample> samples) noexcept {
  std::ranges::copy(samples, samples_.begin());
  for (BodySample& sample : samples_) sample.valid = true;
  for (std::size_t i = 0; i < driven_.size(); ++i) samples_[driven_[i]].target = target(i, t);

  if (link_ != nullptr) joints_.write(link_->rig().joints(), true, samples_);
  for (std::size_t i = 0; i < samples_.size(); ++i) samples_[i].engaged = samples[i].engaged;
  static_cast<void>(engine_->step(samples_));
}

void SimulatedTruth::measure(const Followed& followed, CycleRecord& record) const noexcept {
  record.following = {};
  for (const std::size_t body : followed.bodies) {
    const Pose &X_WH = samples_[body].target.X_WD, &X_WD = followed.samples[body].target.X_WD;
    const BodyView &view = record.bodies[body], exact = engine_->view(body);
    const auto following = [&](const BodyView& of) {
      return between(of.X_WB, followed.by_an_offset ? of.target.X_WD : X_WH);
    };
    record.following = worst(record.following, following(view));
    record.exact_following = worst(record.exact_following, following(exact));
    record.sensing = worst(record.sensing, between(X_WD, X_WH));
    record.encoders = worst(record.encoders, between(view.X_WB, exact.X_WB));
  }
}

std::vector<double> SimulatedTruth::bus_load_percent() const {
  std::vector<double> loads;
  if (link_ != nullptr)
    for (std::size_t i = 0; i < link_->rig().host_buses().size(); ++i)
      loads.push_back(link_->load_percent(i));
  return loads;
}

}  // namespace godobject
