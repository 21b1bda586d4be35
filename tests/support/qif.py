"""QIF documents as text, of the pieces that a test is about."""

from collections.abc import Sequence

UNITS = """<FileUnits><PrimaryUnits>
<AngularUnit><SIUnitName>radian</SIUnitName><UnitName>{angle}</UnitName>
<UnitConversion><Factor>{radians}</Factor></UnitConversion></AngularUnit>
<LinearUnit><SIUnitName>meter</SIUnitName><UnitName>{length}</UnitName>
<UnitConversion><Factor>{metres}</Factor></UnitConversion></LinearUnit>
</PrimaryUnits></FileUnits>"""
MM = UNITS.format(angle="degree", radians="0.017453292519943", length="mm", metres="0.001")
INCH = UNITS.format(angle="degree", radians="0.017453292519943", length="inch", metres="0.0254")
RELATIVE = "<MaxValue>0.03</MaxValue><MinValue>-0.01</MinValue><DefinedAsLimit>false</DefinedAsLimit>"


def characteristic(
    number: int, kind: str = "Diameter", target: str = "10", tolerance: str = RELATIVE, name: str = "D1"
) -> tuple[str, str, str]:
    """Definition, nominal and item of one characteristic: identifiers `number`, + 1 and + 2."""
    target = f"<TargetValue>{target}</TargetValue>" if target else ""
    tolerance = f"<Tolerance>{tolerance}</Tolerance>" if tolerance.startswith("<M") else tolerance
    return (
        f'<{kind}CharacteristicDefinition id="{number}">{tolerance}</{kind}CharacteristicDefinition>',
        f'<{kind}CharacteristicNominal id="{number + 1}"><CharacteristicDefinitionId>{number}'
        f"</CharacteristicDefinitionId>{target}</{kind}CharacteristicNominal>",
        f'<{kind}CharacteristicItem id="{number + 2}"><Name>{name}</Name><CharacteristicNominalId>{number + 1}'
        f"</CharacteristicNominalId></{kind}CharacteristicItem>",
    )


def measured(item: str, value: str, kind: str = "Diameter", status: str = "PASS", more: str = "") -> str:
    """One result of an item; `value` the element's text, or the element itself."""
    value = value if value.startswith("<") or not value else f"<Value>{value}</Value>"
    return (
        f"<{kind}CharacteristicMeasurement><Status><CharacteristicStatusEnum>{status}</CharacteristicStatusEnum>"
        f"</Status><CharacteristicItemId>{item}</CharacteristicItemId>{more}{value}</{kind}CharacteristicMeasurement>"
    )


def results(*values: str, component: str = "900", before: str = "") -> str:
    """One result set of one part."""
    return (
        f"<MeasurementResults>{before}<MeasuredCharacteristics><CharacteristicMeasurements>{''.join(values)}"
        "</CharacteristicMeasurements></MeasuredCharacteristics>"
        f"<ActualComponentIds><Id>{component}</Id></ActualComponentIds></MeasurementResults>"
    )


def document(
    *sets: str,
    characteristics: Sequence[tuple[str, str, str]] = (),
    units: str = MM,
    components: str = '<ActualComponent id="900"><SerialNumber>A01</SerialNumber></ActualComponent>',
    more: str = "",
    head: str = "",
) -> str:
    """The whole: one part type, these characteristics, these result sets."""
    definitions, nominals, items = zip(*characteristics, strict=True) if characteristics else ((), (), ())
    return f"""{head}<QIFDocument xmlns="http://qifstandards.org/xsd/qif3" versionQIF="3.0.0" idMax="999">
{units}<Product><PartSet><Part id="1"><Name>cover</Name><Version>B</Version></Part></PartSet></Product>{more}
<Characteristics><CharacteristicDefinitions>{"".join(definitions)}</CharacteristicDefinitions>
<CharacteristicNominals>{"".join(nominals)}</CharacteristicNominals>
<CharacteristicItems>{"".join(items)}</CharacteristicItems></Characteristics>
<Results><MeasurementResultsSet>{"".join(sets)}</MeasurementResultsSet>
<ActualComponentSets><ActualComponentSet>{components}</ActualComponentSet></ActualComponentSets></Results>
</QIFDocument>"""
