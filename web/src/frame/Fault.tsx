import { i18n } from "@lingui/core";
import { Component, type ReactNode } from "react";

/** Says that a page failed, where it would else be empty; anew on another page (`of`). */
export class Fault extends Component<{ children: ReactNode; of?: string }, { failed: boolean }> {
  override state = { failed: false };

  static getDerivedStateFromError() {
    return { failed: true };
  }

  override componentDidUpdate(before: { of?: string }) {
    if (before.of !== this.props.of && this.state.failed) this.setState({ failed: false });
  }

  override render() {
    return this.state.failed ? <p role="alert">{i18n._("frame.fault")}</p> : this.props.children;
  }
}
