import { usePages } from "../api/asking";
import type { Shape } from "../api/client";
import { Age, Head, More, Opens, Rows, Section, Shown, State } from "../show/parts";
import { useText } from "../text/text";

const HEAD = ["part_type", "serial", "verdict", "at", "by", "open"] as const;

/** All certificates, the latest first. */
export default function Certificates() {
  const text = useText();
  const list = usePages<Shape<"CertificateRow">>("certificates");
  return (
    <>
      <Head title={text("page.certificates")} />
      <Section title={text("page.certificates")}>
        <Shown found={list}>
          {(certificates) => (
            <Rows
              label={text("page.certificates")}
              none={text("certificate.none")}
              head={HEAD.map((one) => text(`head.${one}`))}
              rows={certificates.map((one) => ({
                key: one.id,
                cells: [
                  one.part_type,
                  one.serial,
                  <State kind="verdict" name={one.verdict} />,
                  <Age at={one.made_at} />,
                  one.made_by,
                  <Opens href={`certificates/${one.id}`}>{text("certificate.open")}</Opens>,
                ],
              }))}
            />
          )}
        </Shown>
        <More list={list} />
      </Section>
    </>
  );
}
