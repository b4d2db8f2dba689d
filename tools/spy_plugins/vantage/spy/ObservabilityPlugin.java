package vantage.spy;

import lcm.spy.SpyPlugin;
import vantage_msgs.observability_t;

/** Shows OBSERVABILITY over time, and the ellipsoid of its first two axes. */
public final class ObservabilityPlugin extends ViewPlugin implements SpyPlugin {
  public ObservabilityPlugin() {
    super(observability_t.LCM_FINGERPRINT, "Observability");
  }

  @Override
  View open(String channel) {
    return new ObservabilityView(channel);
  }
}
