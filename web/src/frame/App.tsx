import { i18n } from "@lingui/core";
import { I18nProvider } from "@lingui/react";
import { Button, createTheme, MantineProvider, NativeSelect, PasswordInput, Textarea, TextInput } from "@mantine/core";
import { QueryClientProvider } from "@tanstack/react-query";
import { setNonce } from "get-nonce";

import { client } from "../api/asking";
import { speak } from "../text/text";
import { Fault } from "./Fault";
import { Inside } from "./Inside";

const nonce = document.querySelector<HTMLMetaElement>('meta[name="csp-nonce"]')?.content ?? "";
setNonce(nonce);
speak(navigator.language.slice(0, 2));

// Fingers in gloves: what is pressed is at least 48 px high, which Mantine's size lg is.
const theme = createTheme({
  primaryShade: { light: 8, dark: 8 },
  fontFamily: 'system-ui, "Segoe UI", "Noto Sans", sans-serif',
  components: {
    Button: Button.extend({ defaultProps: { size: "lg" }, styles: { root: { fontSize: "1rem" } } }),
    TextInput: TextInput.extend({ defaultProps: { size: "lg" } }),
    Textarea: Textarea.extend({ defaultProps: { size: "lg" } }),
    PasswordInput: PasswordInput.extend({ defaultProps: { size: "lg" } }),
    NativeSelect: NativeSelect.extend({ defaultProps: { size: "lg" } }),
  },
});

/** The whole application, in its languages, colours and with its one store of answers. */
export function App() {
  return (
    <MantineProvider theme={theme} defaultColorScheme="auto" getStyleNonce={() => nonce}>
      <I18nProvider i18n={i18n}>
        <QueryClientProvider client={client}>
          <Fault>
            <Inside />
          </Fault>
        </QueryClientProvider>
      </I18nProvider>
    </MantineProvider>
  );
}
